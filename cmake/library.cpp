// SPDX-License-Identifier: Apache-2.0
// The shared library is made of the static ones; CMake wants one file of its own.
