// fumarole-pictures.so: what the program opens when it reads or writes a picture.

#include "pictures/table.h"

extern "C" FUMAROLE_API const fumarole::pictures::Table* fumarole_pictures();

const fumarole::pictures::Table* fumarole_pictures()
{
    using namespace fumarole;
    static const pictures::Table table{
        .version = FUMAROLE_VERSION,
        .load_image = &asset::load_image,
        .load_environment = &asset::load_environment,
        .write_exr = &write::write_exr,
        .write_deep_exr = &write::write_deep_exr,
        .read_exr = &write::read_exr,
        .exr_channels = &write::exr_channels,
        .is_whole = &write::is_whole,
    };
    return &table;
}
