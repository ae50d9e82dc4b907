#include "gl/device.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <fmt/format.h>
#include <string_view>

#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

bool is_software(std::string_view renderer)
{
    constexpr std::array<std::string_view, 4> kRasterisers{"llvmpipe", "softpipe", "swrast",
                                                           "software"};
    std::string lower(renderer);
    std::transform(lower.begin(), lower.end(), lower.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return std::any_of(kRasterisers.begin(), kRasterisers.end(), [&](std::string_view name) {
        return lower.find(name) != std::string::npos;
    });
}

}  // namespace

Device::Device(GetProc get_proc, Log log, ProgramStore programs)
    : log_{std::move(log)}, programs_{std::move(programs)}
{
    const int version = gladLoadGLContext(&gl_, get_proc);
    if (version == 0)
        throw Error("OpenGL: no context is current, or its functions can't be found; make a "
                    "context current before the renderer is made");
    const auto text = [&](GLenum name) {
        const GLubyte* value = gl_.GetString(name);
        return std::string(value != nullptr ? reinterpret_cast<const char*>(value) : "unknown");
    };
    if (version < GLAD_MAKE_VERSION(4, 5))
        throw Error(fmt::format("OpenGL {} on {}: version 4.5 or newer is needed; update the "
                                "driver, or use Mesa's llvmpipe",
                                text(GL_VERSION), text(GL_RENDERER)));
    const auto limit = [&](GLenum name) {
        GLint value = 0;
        gl_.GetIntegerv(name, &value);
        return value;
    };
    const auto large = [&](GLenum name) {
        GLint64 value = 0;
        gl_.GetInteger64v(name, &value);
        return value;
    };
    capabilities_ = {.renderer = text(GL_RENDERER),
                     .version = text(GL_VERSION),
                     .software = is_software(text(GL_RENDERER)),
                     .max_texture_2d = limit(GL_MAX_TEXTURE_SIZE),
                     .max_texture_3d = limit(GL_MAX_3D_TEXTURE_SIZE),
                     .max_storage_bytes = large(GL_MAX_SHADER_STORAGE_BLOCK_SIZE),
                     .max_texture_units = limit(GL_MAX_TEXTURE_IMAGE_UNITS),
                     .program_formats = {},
                     .vendor = text(GL_VENDOR),
                     .shading_language = text(GL_SHADING_LANGUAGE_VERSION)};
    if (const int count = limit(GL_NUM_PROGRAM_BINARY_FORMATS); count > 0) {
        std::vector<GLint> formats(static_cast<std::size_t>(count));
        gl_.GetIntegerv(GL_PROGRAM_BINARY_FORMATS, formats.data());
        capabilities_.program_formats.assign(formats.begin(), formats.end());
    }
    if (capabilities_.renderer.find("llvmpipe") != std::string::npos)
        capabilities_.max_loop_turns = 65535;
}

}  // namespace fumarole::gl
