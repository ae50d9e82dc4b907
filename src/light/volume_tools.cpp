#include "light/volume_tools.h"

#include <fmt/format.h>

namespace fumarole::light {

void VolumeTools::bind_block() const
{
    block.write(params);
    device->BindBufferBase(GL_UNIFORM_BUFFER, LIGHT_VOLUMES_BLOCK, block.id());
}

void VolumeTools::dispatch(const char* file, const gl::Defines& defines, const gl::Texture& image,
                           GLenum format, int group, glm::ivec3 nodes) const
{
    device->UseProgram(programs.get({file}, defines).id());
    device->BindImageTexture(0, image.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, format);
    const glm::uvec3 groups((nodes + group - 1) / group);
    device->DispatchCompute(groups.x, groups.y, groups.z);
    device->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);  // for whoever samples it next
}

std::string size_of(const gl::Texture& texture, int layers, std::size_t texel_bytes)
{
    const glm::ivec3 size = texture.size();
    return fmt::format("{} x {} x {} nodes, {:.2f} MB", size.x, size.y, size.z / layers,
                       1e-6 * static_cast<double>(texel_bytes) * size.x * size.y * size.z);
}

std::string filled_in(std::optional<double> ms)
{
    return ms ? fmt::format(" in {:.1f} ms", *ms) : "";
}

}  // namespace fumarole::light
