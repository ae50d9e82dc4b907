#include "light/marched_extinction.h"

#include <algorithm>

#include "light/light_source.h"

namespace fumarole::light {

void MarchedExtinction::set_color(const medium::MediaSet& media)
{
    const std::optional<glm::vec3> color = media.marched_color();
    colored_ = media.traits().marched > 0 && !color;
    tools_.params.extinction_color = glm::vec4(color.value_or(glm::vec3(1)), 1.0f);
}

Lattice MarchedExtinction::lattice_of(const medium::VoxelFrame& frame) const
{
    constexpr int kMostNodes = 128;  // one a voxel up to here
    return make_lattice(frame.voxel_from_world, frame.marched, 1.0,
                        clamp_to(kMostNodes, 1, tools_.device));
}

void MarchedExtinction::fill(const medium::VoxelFrame& frame, medium::MediaSet& media,
                             LightSet& lights)
{
    lattice_ = lattice_of(frame);
    const GLenum format = colored_ ? GL_RGBA32F : GL_R32F;
    volume_ = make_volume(tools_.device, "marched extinction", lattice_, 1, format);
    const glm::dvec3 voxels =
        (frame.marched.max - frame.marched.min) / glm::dvec3(lattice_.count - 1);
    const double coarsest = std::max({voxels.x, voxels.y, voxels.z});
    // Two at least, or a node on the face of what is constant would hold nothing.
    const int least = frame.tiles ? 2 : 1;
    tools_.params.samples = std::clamp(static_cast<int>(coarsest), least, kMostSamples);
    const glm::dvec3 eye = centre_of(lattice_);
    media.bind(eye, true);
    lights.bind(eye);
    write_params(eye);
    tools_.bind_block();
    tools_.dispatch("light/extinction.comp", fill_defines(media, write_lights({})), volume_, format,
                    VOLUME_GROUP, lattice_.count);
    ++fills_;
}

void MarchedExtinction::write_params(glm::dvec3 eye) const
{
    tools_.params.extinction = to_shared(lattice_, 1, eye);
}

gl::Defines MarchedExtinction::fill_defines(const medium::MediaSet& media,
                                            const gl::Defines& own) const
{
    gl::Defines defines = media.defines();
    defines += own;
    if (colored_)
        defines.emplace_back("VOLUME_RGB", "");
    return defines;
}

}  // namespace fumarole::light
