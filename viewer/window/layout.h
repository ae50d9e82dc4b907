#pragma once

#include <glm/glm.hpp>

namespace fumarole::window {

/// The smallest window that has room for panels, in its own units; a smaller one says so instead.
inline constexpr glm::ivec2 kMinWindowSize{200, 150};

/// A rectangle of the window, in the window's own units from its top left.
struct Area {
    glm::dvec2 at{0}, size{0};

    [[nodiscard]] bool holds(glm::dvec2 p) const
    {
        return glm::all(glm::greaterThanEqual(p, at)) && glm::all(glm::lessThan(p, at + size));
    }
    /// A place as a share of the rectangle: 0..1 within it.
    [[nodiscard]] glm::dvec2 share(glm::dvec2 p) const { return (p - at) / size; }
    [[nodiscard]] double aspect() const { return size.x / size.y; }
};

/// How the window is divided: the panel at the left, the timeline below, the picture in the rest.
struct Layout {
    glm::ivec2 window{0};       ///< size of the whole window, in its own units
    glm::ivec2 framebuffer{0};  ///< size of the whole window, in pixels
    Area picture;
    float panel_width = 0;      ///< 0 where the panel is off, or has no room beside a picture
    float timeline_height = 0;  ///< 0 where nothing plays, or there is no room

    [[nodiscard]] bool too_small() const
    {
        return window.x < kMinWindowSize.x || window.y < kMinWindowSize.y;
    }
    /// Size of the picture, in pixels of the framebuffer, at least 1 x 1.
    [[nodiscard]] glm::ivec2 picture_pixels() const;
    /// The picture's lower left corner, in pixels of the framebuffer, whose rows run from the
    /// bottom.
    [[nodiscard]] glm::ivec2 picture_lower_left() const;
};

/// Divides a window. @param em height of a letter, in the window's units
/// @param panel true if the panel is wanted @param timeline true if the scene has frames to play
Layout lay_out(glm::ivec2 window, glm::ivec2 framebuffer, float em, bool panel, bool timeline);

}  // namespace fumarole::window
