#include "asset/printable.h"

#include <fmt/format.h>

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

}  // namespace fumarole::asset
