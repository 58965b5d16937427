// SPDX-License-Identifier: Apache-2.0
#include "video/finished_video.h"

#include "video/gif.h"
#include "video/matroska.h"
#include "video/mp4.h"

namespace gnomon::video {

bool is_whole_video(const std::filesystem::path& file, Container container)
{
    switch (container) {
        case Container::mkv:
        case Container::webm:
            return is_whole_matroska(file);
        case Container::gif:
            return is_whole_gif(file);
        case Container::mp4:
        case Container::mov:
            break;
    }
    return is_whole_mp4(file);
}

std::string comment_of_video(const std::filesystem::path& file, Container container)
{
    switch (container) {
        case Container::mkv:
        case Container::webm:
            return comment_of_matroska(file);
        case Container::gif:
            return comment_of_gif(file);
        case Container::mp4:
        case Container::mov:
            break;
    }
    return comment_of_mp4(file);
}

}   // namespace gnomon::video
