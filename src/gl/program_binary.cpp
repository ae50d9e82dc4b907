#include "gl/program_binary.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <fmt/format.h>

namespace fumarole::gl {

namespace {

constexpr std::uint64_t kFnvBasis = 0xcbf29ce484222325, kFnvPrime = 0x100000001b3;
constexpr std::uint64_t kOtherPrime = 0x9e3779b97f4a7c15;  // odd, for a second hash of its own

/// 64-bit FNV-1a, which goes on from `hash`.
std::uint64_t fnv(std::uint64_t hash, const void* bytes, std::size_t count,
                  std::uint64_t prime = kFnvPrime)
{
    const auto* at = static_cast<const unsigned char*>(bytes);
    for (std::size_t i = 0; i < count; ++i)
        hash = (hash ^ at[i]) * prime;
    return hash;
}

/// Ahead of the driver's bytes. The key is there since files are copied and renamed.
struct Header {
    std::array<char, 8> magic{'F', 'U', 'M', 'P', 'R', 'O', 'G', '1'};
    std::array<char, 32> key{};
    std::uint64_t format = 0;
    std::uint64_t bytes = 0, hash = 0;  ///< bytes and hash of what follows, and of the format
};
static_assert(sizeof(Header) == 64);

std::uint64_t hash_of(std::uint64_t format, const std::byte* bytes, std::size_t count)
{
    return fnv(fnv(kFnvBasis, &format, sizeof format), bytes, count);
}

bool takes_format(const Device& gl, GLenum format)
{
    const std::vector<GLenum>& formats = gl.capabilities().program_formats;
    return std::find(formats.begin(), formats.end(), format) != formats.end();
}

}  // namespace

std::string program_key(const std::vector<std::string_view>& texts)
{
    std::uint64_t first = kFnvBasis, second = kFnvBasis;
    for (const std::string_view text : texts) {
        const std::uint64_t length = text.size();  // or "ab", "c" were "a", "bc"
        for (auto [hash, prime] : {std::pair{&first, kFnvPrime}, {&second, kOtherPrime}})
            *hash = fnv(fnv(*hash, &length, sizeof length, prime), text.data(), text.size(), prime);
    }
    return fmt::format("{:016x}{:016x}", first, second);
}

std::vector<std::byte> pack_program(const ProgramBinary& program, std::string_view key)
{
    Header header;
    std::copy_n(key.begin(), std::min(key.size(), header.key.size()), header.key.begin());
    header.format = program.format;
    header.bytes = program.bytes.size();
    header.hash = hash_of(header.format, program.bytes.data(), program.bytes.size());
    std::vector<std::byte> packed(sizeof header + program.bytes.size());
    std::memcpy(packed.data(), &header, sizeof header);
    std::copy(program.bytes.begin(), program.bytes.end(), packed.begin() + sizeof header);
    return packed;
}

std::optional<ProgramBinary> unpack_program(const std::vector<std::byte>& packed,
                                            std::string_view key)
{
    Header header;
    if (packed.size() <= sizeof header)
        return std::nullopt;
    std::memcpy(&header, packed.data(), sizeof header);
    const std::byte* bytes = packed.data() + sizeof header;
    const std::size_t count = packed.size() - sizeof header;
    if (header.magic != Header{}.magic || header.bytes != count ||
        std::string_view(header.key.data(), header.key.size()) != key ||
        header.hash != hash_of(header.format, bytes, count))
        return std::nullopt;
    return ProgramBinary{static_cast<GLenum>(header.format), {bytes, bytes + count}};
}

bool load_program(const Device& gl, GLuint program, std::string_view key)
{
    const std::optional<ProgramBinary> stored = unpack_program(gl.programs().load(key), key);
    // An unknown format would be a GL error, which a host in debug mode is told of.
    if (!stored || !takes_format(gl, stored->format))
        return false;
    gl->ProgramBinary(program, stored->format, stored->bytes.data(),
                      static_cast<GLsizei>(stored->bytes.size()));
    GLint linked = GL_FALSE;
    gl->GetProgramiv(program, GL_LINK_STATUS, &linked);
    return linked == GL_TRUE;
}

void store_program(const Device& gl, GLuint program, std::string_view key)
{
    GLint length = 0;
    gl->GetProgramiv(program, GL_PROGRAM_BINARY_LENGTH, &length);
    if (length <= 0)
        return;
    ProgramBinary binary;
    binary.bytes.resize(static_cast<std::size_t>(length));
    GLsizei written = 0;
    gl->GetProgramBinary(program, length, &written, &binary.format, binary.bytes.data());
    if (written <= 0)
        return;
    binary.bytes.resize(static_cast<std::size_t>(written));
    gl.programs().store(key, pack_program(binary, key));
}

}  // namespace fumarole::gl
