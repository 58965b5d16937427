// SPDX-License-Identifier: Apache-2.0
#pragma once
// A scene as a simulator uploads it: glTF, of which the camera and the nodes' matrices change from request to request,
// and the rest seldom does.

#include <nlohmann/json.hpp>

#include <map>
#include <string>
#include <vector>

#include "gnomon/math.h"

namespace gnomon::cli {

struct Upload {
    /// The file without its cameras and without the `matrix` of its nodes; two files that are equal here show the same
    /// things at other places.
    nlohmann::json rest;
    std::string binary;   // of a .glb: what follows the JSON
    bool is_binary = false;
    std::vector<Transform> matrices;   // of the nodes, in the file's order; the identity where a node has no `matrix`
    Transform camera_to_world;         // of the first node with a camera
    bool has_lights = false;           // KHR_lights_punctual

    bool shows_the_same_as(const Upload& other) const
    {
        return is_binary == other.is_binary && binary == other.binary && rest == other.rest;
    }
};

/// Reads what the server needs to know; the importer checks the rest.
/// @throws UsageError  no glTF, no camera in it, or nested too deeply
Upload read_upload(const std::string& file);

}   // namespace gnomon::cli
