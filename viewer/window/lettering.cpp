#include "window/lettering.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <imgui.h>

namespace fumarole::window {

namespace {

/// Ends of what a font may have beyond Latin-1 in the basic plane, but for surrogates and private
/// use. Marks that say how to write, and have no shape, are left out with them.
constexpr std::pair<int, int> kPlaces[] = {{0x0100, 0x200a}, {0x2010, 0x2027}, {0x2030, 0x205f},
                                           {0x2070, 0xd7ff}, {0xf900, 0xfdff}, {0xfe10, 0xfefe},
                                           {0xff01, 0xffef}};

/// An em of these fonts is a smaller part of a line than one of ours, and their strokes are many.
constexpr float kLarger = 1.15f;

bool has(const ImFont& font, char16_t letter)
{
    return font.FindGlyphNoFallback(letter) != nullptr;
}

}  // namespace

bool Lettering::update(ImFontAtlas& atlas, float pixels)
{
    bool found = false;
    if (search_ != nullptr) {
        const std::lock_guard guard(search_->lock);
        found = search_->done;
    }
    if (found) {
        for (FontFile& font : search_->fonts) {
            const auto same = std::ranges::find_if(fonts_, [&](const FontFile& one) {
                return one.file == font.file && one.index == font.index;
            });
            if (same == fonts_.end())
                fonts_.push_back(std::move(font));
            else
                same->letters.merge(font.letters);
        }
        searched_.insert(under_way_.begin(), under_way_.end());
        search_.reset();
    }
    if (!found && pixels == pixels_)
        return false;
    pixels_ = pixels;
    build(atlas);
    if (found)
        tell_of_missing(atlas, std::exchange(under_way_, {}));
    return true;
}

void Lettering::build(ImFontAtlas& atlas)
{
    atlas.Clear();
    ImFontConfig own;
    own.SizePixels = pixels_;
    ImFont& all = *atlas.AddFontDefault(&own);
    std::vector<std::vector<ImWchar>> ranges;  // read while the atlas is built
    for (FontFile& font : fonts_) {
        std::vector<ImWchar>& range = ranges.emplace_back();
        for (const char16_t letter : font.letters)
            range.insert(range.end(), 2, letter);
        range.push_back(0);
        ImFontConfig more;
        more.MergeMode = true;
        more.FontDataOwnedByAtlas = false;
        more.FontNo = font.index;
        more.OversampleH = 2;
        more.GlyphOffset.y = std::round(pixels_ / 15);  // our own letters sit this much lower
        atlas.AddFontFromMemoryTTF(font.data.data(), static_cast<int>(font.data.size()),
                                   pixels_ * kLarger, &more, range.data());
    }
    atlas.Build();
    all.Glyphs.reserve(all.Glyphs.Size + 0xffff);
    for (const auto& [first, last] : kPlaces)
        for (int code = first; code <= last; ++code) {
            const auto letter = static_cast<char16_t>(code);
            const float mark = -static_cast<float>(code);
            if (!searched_.contains(letter) && !has(all, letter))
                all.AddGlyph(nullptr, letter, 0, 0, pixels_, pixels_, mark, 0, mark, 0, pixels_);
        }
    all.BuildLookupTable();
}

void Lettering::look_at(ImDrawData& frame)
{
    wanted_.clear();
    for (int i = 0; i < frame.CmdListsCount; ++i)
        for (ImDrawVert& corner : frame.CmdLists[i]->VtxBuffer)
            if (corner.uv.x <= -static_cast<float>(kPlaces[0].first)) {
                wanted_.insert(static_cast<char16_t>(-corner.uv.x));
                corner.col = 0;
            }
    if (!wanted_.empty() && search_ == nullptr)
        begin_search();
}

void Lettering::begin_search()
{
    search_ = std::make_shared<Search>();
    under_way_ = wanted_;
    background_.run([search = search_, letters = wanted_](const Background::Stop&) {
        std::vector<FontFile> fonts = find_fonts(letters);
        const std::lock_guard guard(search->lock);
        search->fonts = std::move(fonts);
        search->done = true;
    });
}

void Lettering::tell_of_missing(const ImFontAtlas& atlas, const std::set<char16_t>& letters)
{
    std::vector<char16_t> missing;
    std::ranges::copy_if(letters, std::back_inserter(missing),
                         [&](char16_t letter) { return !has(*atlas.Fonts[0], letter); });
    if (missing.empty() || std::exchange(told_, true))
        return;
    note_ = fmt::format("no font of this computer has U+{:04X}{}, and a question mark stands for "
                        "it; fonts-wqy-microhei "
                        "of Debian has Chinese, Japanese, Korean, Cyrillic and Greek letters",
                        static_cast<int>(missing[0]),
                        missing.size() > 1 ? fmt::format(" or {} more", missing.size() - 1) : "");
}

}  // namespace fumarole::window
