#pragma once

#include <memory>
#include <mutex>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "window/background.h"
#include "window/font_files.h"

struct ImDrawData;
struct ImFontAtlas;

namespace fumarole::window {

/// The window's letters. Dear ImGui's own font has those of Western Europe; what a name or a
/// message has beyond them comes from the computer's fonts once it is to be seen, so a window
/// without any pays for none. Until a letter is there its place is empty, for a few frames. One
/// that no font has is a question mark.
///
/// Every letter that could come has a placeholder whose texture coordinate is its code, negated:
/// what a frame has drawn thus says which letters are wanted, whoever wrote them and in whatever
/// box. Letters stand one by one: scripts that join them are not shaped.
class Lettering {
public:
    /// Makes the atlas anew if the size is another or letters have come. Between frames.
    /// @param pixels height of a line. Returns whether it did: its texture is out of date then
    bool update(ImFontAtlas& atlas, float pixels);

    /// Takes note of the letters that a frame lacks, and takes their placeholders out of it.
    void look_at(ImDrawData& frame);

    /// Whether the last frame has all letters that it can have.
    [[nodiscard]] bool complete() const { return wanted_.empty(); }
    /// What a person should know about missing letters, once, or "".
    std::string take_note() { return std::exchange(note_, ""); }

private:
    struct Search {
        std::mutex lock;
        bool done = false;
        std::vector<FontFile> fonts;
    };

    void begin_search();
    void build(ImFontAtlas& atlas);
    void tell_of_missing(const ImFontAtlas& atlas, const std::set<char16_t>& letters);

    float pixels_ = 0;
    std::set<char16_t> wanted_;    ///< of the last frame, that are still looked for
    std::set<char16_t> searched_;  ///< found or not
    std::set<char16_t> under_way_;
    std::vector<FontFile> fonts_;
    std::shared_ptr<Search> search_;
    std::string note_;
    bool told_ = false;
    Background background_;  // last: its thread ends first
};

}  // namespace fumarole::window
