#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gl/device.h"

namespace fumarole::gl {

/// A program as a driver has compiled it.
struct ProgramBinary {
    GLenum format = 0;  ///< one of GL_PROGRAM_BINARY_FORMATS
    std::vector<std::byte> bytes;

    bool operator==(const ProgramBinary&) const = default;
};

/// 32 hexadecimal digits of some texts and their order (FNV-1a, twice 64 bits): nobody's secret,
/// and two of them meet by chance once in 2^64 programs.
std::string program_key(const std::vector<std::string_view>& texts);

/// What is stored: the binary, and what tells that it is whole and that it is this key's.
std::vector<std::byte> pack_program(const ProgramBinary& program, std::string_view key);
/// Nothing if it is damaged, cut off, or another key's.
std::optional<ProgramBinary> unpack_program(const std::vector<std::byte>& packed,
                                            std::string_view key);

/// Gives a program what is stored for it. @returns whether it is linked now; if not it can be
/// linked from its shaders as if nothing had been tried, and no GL error is left.
bool load_program(const Device& gl, GLuint program, std::string_view key);
/// Stores a program that was linked with GL_PROGRAM_BINARY_RETRIEVABLE_HINT.
void store_program(const Device& gl, GLuint program, std::string_view key);

}  // namespace fumarole::gl
