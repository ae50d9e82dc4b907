#pragma once

#include <string_view>

#include <glm/glm.hpp>

#include <fumarole/write/image_writer.h>

namespace fumarole::study {

/// Text for pictures, without a font file: capitals, digits and . , : - _ + % / ( ) < > = ^, in
/// cells of 6 x 8 pixels times `scale`. Small letters are drawn as capitals, what is unknown as a
/// box. Width and height in pixels, without the space after the last letter and under the line.
int label_width(std::string_view text, int scale);
int label_height(int scale);

/// Draws into the picture's first three channels with the upper left corner at x, y; what lies
/// outside is left out. `color` is linear, as the picture is. The picture has three channels or
/// more.
void draw_label(Image& image, int x, int y, std::string_view text, glm::vec3 color, int scale);

}  // namespace fumarole::study
