#include "study/panels.h"

namespace fumarole::study {

Image blank_sheet(int width, int height)
{
    Image sheet{width, height, {"R", "G", "B"}, {}};
    sheet.pixels.assign(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height),
                        1.0f);
    return sheet;
}

void paste(Image& sheet, const Image& panel, int left, int top)
{
    for (int y = 0; y < panel.height; ++y)
        for (int x = 0; x < panel.width; ++x)
            for (int c = 0; c < 3; ++c)
                sheet.pixels[static_cast<std::size_t>(((top + y) * sheet.width + left + x) * 3 +
                                                      c)] = panel.at(x, y, c);
}

}  // namespace fumarole::study
