// SPDX-License-Identifier: Apache-2.0
#pragma once
// The exceptions the library throws, one type for each thing a caller can do about it.
//
// Assert for our bug, exception for the world, return value for the expected. `what()` is always one line, ready to be
// shown to a person.

#include <stdexcept>
#include <string>

namespace gnomon {

/// Everything the library throws derives from this.
class Error : public std::runtime_error {
 public:
    using std::runtime_error::runtime_error;
};

/// A file that cannot be used: names the file, the place in it, and what is wrong there. Exit code 3.
class InputError : public Error {
 public:
    /// @param file   path as the user gave it, or as the file that names it does
    /// @param place  "line:column", a JSON pointer, "byte N", or empty where the whole file is meant
    /// @param what   one clause without a full stop: "expected 3 numbers, found '}'"
    InputError(std::string file, std::string place, std::string what);

    const std::string& file() const noexcept { return file_; }
    const std::string& place() const noexcept { return place_; }
    const std::string& problem() const noexcept { return problem_; }

 private:
    std::string file_, place_, problem_;
};

/// An option or argument that makes no sense. Exit code 2.
class UsageError : public Error {
 public:
    using Error::Error;
};

/// Something the machine lacks: a device, a driver, ffmpeg, room on the disk, a writable folder. Exit code 4.
class MissingError : public Error {
 public:
    using Error::Error;
};

/// The caller asked to stop (see Progress). Exit code 130.
class InterruptedError : public Error {
 public:
    using Error::Error;
};

/// A check of ours failed: a bug of the library. Exit code 5.
class InternalError : public Error {
 public:
    using Error::Error;
};

}   // namespace gnomon
