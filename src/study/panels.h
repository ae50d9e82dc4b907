#pragma once

#include <fumarole/write/image_writer.h>

namespace fumarole::study {

/// White paper for several pictures: R, G, B, linear.
Image blank_sheet(int width, int height);

/// Copies a panel's first three channels to where its upper left corner is to be; it fits.
void paste(Image& sheet, const Image& panel, int left, int top);

}  // namespace fumarole::study
