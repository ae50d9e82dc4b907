#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <utility>

#include "asset/vdb_layout.h"
#include <fumarole/asset/load_limits.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

/// The bytes of a file, read from the disk where they are asked for first.
class LazyBytes {
public:
    LazyBytes(std::ifstream file, VdbLayout& layout) : file_(std::move(file)), layout_(layout) {}

    void read_all() { read(0, layout_.size); }
    /// Reads [begin, end) unless it was read last; `end` is within the file.
    void need(std::size_t begin, std::size_t end)
    {
        constexpr std::size_t kAtLeast = 1 << 14;
        if (begin < begin_ || end > end_)
            read(begin, std::min(layout_.size, std::max(end, begin + kAtLeast)));
    }

private:
    void read(std::size_t begin, std::size_t end)
    {
        constexpr std::size_t kAtOnce = std::size_t(1) << 24;  // some milliseconds of a slow disk
        file_.seekg(std::streamoff(begin));
        for (std::size_t at = begin; at < end; at += std::min(kAtOnce, end - at)) {
            check_cancelled(layout_.file);
            const std::size_t part = std::min(kAtOnce, end - at);
            file_.read(layout_.bytes.get() + at, std::streamsize(part));
            if (std::size_t(file_.gcount()) != part)
                throw Error(fmt::format("{}: can't be read to its end", layout_.file.string()));
        }
        begin_ = begin;
        end_ = end;
    }

    std::ifstream file_;
    VdbLayout& layout_;
    std::size_t begin_ = 0, end_ = 0;  ///< what was read last
};

}  // namespace fumarole::asset
