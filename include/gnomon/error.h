// SPDX-License-Identifier: Apache-2.0
#pragma once
// The exceptions that the library throws, one type for each way in which a caller can react.
//
// A failed internal check throws InternalError, and expected outcomes are return values. `what()` is always one line
// that can be shown to the user: '?' stands for control characters and for bytes that are not UTF-8.

#include <stdexcept>
#include <string>

namespace gnomon {

/// Base class of all exceptions that the library throws.
class Error : public std::runtime_error {
 public:
    /// @param message  one clause without a full stop; what() is this in one line
    explicit Error(const std::string& message);
};

/// An input file that cannot be used. The message names the file, the place in it and the fault. Exit code 3.
class InputError : public Error {
 public:
    /// @param file   path as the user gave it, or as another file refers to it
    /// @param place  "line:column", a JSON pointer, "byte N", or empty if the whole file is meant
    /// @param what   one clause without a full stop: "expected 3 numbers, found '}'"
    InputError(std::string file, std::string place, std::string what);

    /// The path of the file.
    const std::string& file() const noexcept { return file_; }
    /// The place in the file; empty if the whole file is meant.
    const std::string& place() const noexcept { return place_; }
    /// What is wrong there.
    const std::string& problem() const noexcept { return problem_; }

 private:
    std::string file_, place_, problem_;
};

/// An option or argument that is invalid. Exit code 2.
class UsageError : public Error {
 public:
    using Error::Error;
};

/// Something that the machine lacks: a device, a driver, ffmpeg, disk space, a writable folder. Exit code 4.
class MissingError : public Error {
 public:
    using Error::Error;
};

/// The caller asked to stop (see Progress). Exit code 130.
class InterruptedError : public Error {
 public:
    using Error::Error;
};

/// An internal check failed, which is a bug of the library. Exit code 5.
class InternalError : public Error {
 public:
    using Error::Error;
};

}   // namespace gnomon
