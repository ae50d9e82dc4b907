#pragma once

#include <glm/glm.hpp>
#include <map>
#include <string>

#include "gl/texture.h"
#include "window/file_browser.h"

namespace fumarole::window {

/// The browser's part of the window: its path, its entries as pictures with names, and what is
/// known of the chosen one.
class BrowserPanel {
public:
    explicit BrowserPanel(const gl::Device& device) : device_{device} {}

    /// @param size of the window, in its own units
    void draw(FileBrowser& browser, glm::vec2 size);

private:
    struct Cell {
        glm::vec2 at, size;
        bool chosen, hovered;
    };
    void draw_path(FileBrowser& browser);
    void draw_entries(FileBrowser& browser, float height);
    void draw_cell(const FileEntry& entry, const Thumbnail& thumbnail, const Cell& cell);
    static void draw_chosen(FileBrowser& browser);
    /// @returns the texture's name, or 0 while there is none
    unsigned texture_of(const FileEntry& entry, const Thumbnail& thumbnail);

    const gl::Device& device_;
    std::map<std::string, gl::Texture> textures_;  ///< by the file that they are of
    std::string folder_;                           ///< that the textures are of
    std::string path_;                             ///< being typed
    int uploads_left_ = 0;                         ///< in this frame
};

}  // namespace fumarole::window
