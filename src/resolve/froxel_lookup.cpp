#include "resolve/froxel_lookup.h"

#include "shared/bindings.h"

namespace fumarole::resolve {

namespace {

gl::Defines bind_integrated(const PreparedFrame& frame, const pass::IntegratedFroxels& froxels)
{
    gl::Defines defines = froxels.defines;
    if (frame.settings.lookup == Settings::Lookup::tricubic)
        defines.emplace_back("kTricubic", "");
    froxels.scattering->bind(INTEGRATED_SCATTERING_UNIT);
    froxels.transmittance->bind(INTEGRATED_TRANSMITTANCE_UNIT);
    return defines;
}

}  // namespace

gl::Defines bind_lookup(const PreparedFrame& frame, const pass::IntegratedFroxels& froxels)
{
    gl::Defines defines = bind_integrated(frame, froxels);
    defines.add_file("written/volume_at.glsl",
                     "#include \"scene/volume_at_froxels.glsl\"\n"
                     "#define VolumeRay FroxelRay\n#define volume_ray froxel_ray\n");
    return defines;
}

void look_up(const Toolbox& tools, const PreparedFrame& frame,
             const pass::IntegratedFroxels& froxels, Layer layer, const Canvas& canvas,
             const gl::Defines& variant)
{
    gl::Defines defines = bind_integrated(frame, froxels);
    defines += variant;
    if (layer == Layer::transmittance)
        defines.emplace_back("kTransmittance", "");
    if (layer == Layer::both)
        defines.emplace_back("BOTH", "");
    if (canvas.image)
        tools.dispatch_over(frame.picture_size, "resolve/froxels.comp", defines);
    else
        tools.draw_fullscreen("resolve/froxels.frag", defines);
}

}  // namespace fumarole::resolve
