#include "window/layout.h"

namespace fumarole::window {

namespace {

constexpr float kPanelWidth = 25;        // [em]
constexpr float kMinTimelineWidth = 30;  // [em]: its buttons and a slider that can be hit
constexpr float kTimelineHeight = 2.4f;  // [em]

}  // namespace

glm::ivec2 Layout::picture_pixels() const
{
    const glm::dvec2 scale = glm::dvec2(framebuffer) / glm::dvec2(window);
    return glm::max(glm::ivec2(picture.size * scale + 0.5), glm::ivec2(1));
}

glm::ivec2 Layout::picture_lower_left() const
{
    const glm::dvec2 scale = glm::dvec2(framebuffer) / glm::dvec2(window);
    const glm::ivec2 top_left(picture.at * scale + 0.5);
    return {top_left.x, framebuffer.y - picture_pixels().y - top_left.y};
}

Layout lay_out(glm::ivec2 window, glm::ivec2 framebuffer, float em, bool panel, bool timeline)
{
    const glm::dvec2 size(window);
    Layout layout{.window = window, .framebuffer = framebuffer, .picture = {}};
    if (panel && size.x >= kPanelWidth * em + kMinWindowSize.x)
        layout.panel_width = kPanelWidth * em;
    if (timeline && size.x - layout.panel_width > kMinTimelineWidth * em)
        layout.timeline_height = kTimelineHeight * em;
    layout.picture.at = {layout.panel_width, 0};
    layout.picture.size = {size.x - layout.panel_width, size.y - layout.timeline_height};
    return layout;
}

}  // namespace fumarole::window
