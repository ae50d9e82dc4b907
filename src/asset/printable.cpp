#include "asset/printable.h"

#include <cerrno>
#include <fmt/format.h>
#include <fstream>
#include <system_error>

#include <fumarole/errors.h>

namespace fumarole::asset {

std::string printable(std::string_view text, std::size_t max_bytes)
{
    std::string out;
    for (const char c : text.substr(0, max_bytes)) {
        const auto byte = static_cast<unsigned char>(c);
        if (byte < 0x20 || byte == 0x7f)
            out += fmt::format("\\x{:02x}", byte);
        else
            out += c;
    }
    if (text.size() > max_bytes) {
        // A cut through the middle of a UTF-8 sequence would make the message invalid.
        while (!out.empty() && (static_cast<unsigned char>(text[max_bytes]) & 0xc0U) == 0x80 &&
               (static_cast<unsigned char>(out.back()) & 0x80U) != 0) {
            const bool lead = (static_cast<unsigned char>(out.back()) & 0x40U) != 0;
            out.pop_back();
            if (lead)
                break;
        }
        out += "...";
    }
    return out;
}

void fail(const std::filesystem::path& file, const std::string& problem)
{
    throw Error(fmt::format("{}: {}", file.string(), problem));
}

void check_file(const std::filesystem::path& file, std::string_view what)
{
    std::error_code unknown;
    const std::filesystem::file_status status = std::filesystem::status(file, unknown);
    if (status.type() == std::filesystem::file_type::not_found)
        fail(file, fmt::format("no such {}", what));
    if (unknown)
        fail(file, "cannot be opened: " + unknown.message());
    if (!std::filesystem::is_regular_file(status))
        fail(file, "is not a file");
    errno = 0;
    if (!std::ifstream(file, std::ios::binary))
        fail(file,
             "cannot be opened: " + std::generic_category().message(errno != 0 ? errno : EIO));
}

}  // namespace fumarole::asset
