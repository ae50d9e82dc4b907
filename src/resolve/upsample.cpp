#include "resolve/upsample.h"

#include <fmt/format.h>

#include "shared/bindings.h"

namespace fumarole::resolve {

void upsample(const PreparedFrame& frame, const pass::MarchedLayer& marched, Layer layer,
              const Canvas& canvas, const gl::Defines& variant)
{
    const FrameSettings& s = frame.settings;
    const bool small = s.upsample == Settings::Upsample::bilinear2x2;
    gl::Defines defines = variant;
    defines += {{"kLayerScale", fmt::format("{}", s.resolution)},
                {"kUpsampleTaps", s.resolution == 1 ? "1" : (small ? "2" : "4")}};
    if (s.upsample == Settings::Upsample::box4x4)
        defines.emplace_back("kBox2017", "");
    marched.depth->bind(LAYER_DEPTH_UNIT);
    (layer == Layer::transmittance ? marched.transmittance : marched.scattering)
        ->bind(SCATTERING_UNIT);
    if (layer == Layer::both) {
        marched.transmittance->bind(TRANSMITTANCE_UNIT);
        defines.emplace_back("BOTH", "");
    }
    if (!canvas.image)
        defines.emplace_back("FRAME_VARYINGS", "");
    marched.tiles->run_picture("resolve/upsample", defines, canvas.image.has_value());
}

}  // namespace fumarole::resolve
