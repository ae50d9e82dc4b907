#pragma once

#include <charconv>
#include <fmt/format.h>
#include <string>

#include "command.h"
#include "study/shard.h"

namespace fumarole::command {

/// Of --shard's text, INDEX/COUNT; "" is all of the work. @throws UsageError
inline study::Shard parse_shard(const std::string& text)
{
    study::Shard shard;
    if (text.empty())
        return shard;
    const char* end = text.data() + text.size();
    const auto first = std::from_chars(text.data(), end, shard.index);
    const bool slash = first.ec == std::errc() && first.ptr != end && *first.ptr == '/';
    const auto second = slash ? std::from_chars(first.ptr + 1, end, shard.count) : first;
    if (!slash || second.ec != std::errc() || second.ptr != end || shard.index < 1 ||
        shard.index > shard.count)
        throw UsageError(fmt::format(
            "--shard: '{}' is no share INDEX/COUNT, as 2/4 is the second of four", text));
    return shard;
}

}  // namespace fumarole::command
