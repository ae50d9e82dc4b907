#include "resolve/froxel_lookup.h"

#include "shared/bindings.h"

namespace fumarole::resolve {

void look_up(const Toolbox& tools, const PreparedFrame& frame,
             const pass::IntegratedFroxels& froxels, Layer layer)
{
    gl::Defines defines = froxels.storage;
    if (frame.settings.lookup == Settings::Lookup::tricubic)
        defines.emplace_back("kTricubic", "");
    if (layer == Layer::transmittance)
        defines.emplace_back("kTransmittance", "");
    if (layer == Layer::both)
        defines.emplace_back("BOTH", "");
    froxels.scattering->bind(INTEGRATED_SCATTERING_UNIT);
    froxels.transmittance->bind(INTEGRATED_TRANSMITTANCE_UNIT);
    tools.draw_fullscreen("resolve/froxels.frag", defines);
}

}  // namespace fumarole::resolve
