#pragma once

#include <optional>
#include <string>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "gl/timer.h"
#include "shared/light_volume_params.h"

namespace fumarole::light {

/// Most samples of the media along an edge of a node's cell that is larger than a voxel.
constexpr int kMostSamples = 4;

/// What volumes of light share: how they are filled, and the block by which
/// glsl/scene/light_volumes.glsl looks them up. Each writes its own part of it.
struct VolumeTools {
    VolumeTools(const gl::Device& device, gl::ProgramCache& programs, const gl::PassTimers& timers)
        : device{device}, programs{programs}, timers{timers}, block{device, "light volumes"}
    {
    }

    /// Binds the block, as params are now.
    void bind_block() const;

    /// A compute shader over so many nodes, in groups of `group` along each axis.
    void dispatch(const char* file, const gl::Defines& defines, const gl::Texture& image,
                  GLenum format, int group, glm::ivec3 nodes) const;

    const gl::Device& device;
    gl::ProgramCache& programs;
    const gl::PassTimers& timers;
    gl::UniformBuffer<shared::LightVolumesParams> block;
    shared::LightVolumesParams params{};
};

/// A volume's nodes and bytes, as describe() says them.
std::string size_of(const gl::Texture& texture, int layers, std::size_t texel_bytes);

/// Likewise the time that it took to fill; nothing where it was not measured.
std::string filled_in(std::optional<double> ms);

}  // namespace fumarole::light
