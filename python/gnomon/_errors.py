# SPDX-License-Identifier: Apache-2.0
"""The exceptions of the package."""


class Error(Exception):
    """Base class of all exceptions that the renderer raises. str() is one line that can be shown to a user."""


class InputError(Error, ValueError):
    """An input file that cannot be used."""

    file: str
    """Path of the file, as it was given or as another file refers to it."""
    place: str
    """'line:column', a JSON pointer, 'byte N', or '' if the whole file is meant."""
    problem: str
    """What is wrong there."""

    def __init__(self, message: str, file: str = "", place: str = "", problem: str = "") -> None:
        super().__init__(message)
        self.file, self.place, self.problem = file, place, problem


class UsageError(Error, ValueError):
    """An option or argument that is invalid, an id of another scene, or a call at the wrong time."""


class MissingError(Error, RuntimeError):
    """Something that the machine lacks: memory, a Vulkan device, disk space, a folder that can be written to."""


class Interrupted(Error):
    """The work was stopped, by cancel() or by a progress callback that returned False. Ctrl-C raises KeyboardInterrupt."""


class InternalError(Error, RuntimeError):
    """An internal check failed, which is a bug of the library."""
