#include "light/island_light.h"

#include <glm/gtc/matrix_transform.hpp>

namespace fumarole::light {

void IslandLight::set(const std::vector<Part>& parts)
{
    glm::ivec3 size(0);
    first_.clear();
    for (const Part& part : parts) {
        first_.push_back(part.light ? size.z : -1);
        if (!part.light)
            continue;
        const glm::ivec3 own = part.light.size();
        size = glm::ivec3(glm::max(size.x, own.x), glm::max(size.y, own.y), size.z + own.z);
    }
    if (!light_ || light_.size() != size)
        light_ = gl::Texture::make_3d(device_, "world's light in parts that lie far apart", size,
                                      GL_RGBA16F, gl::Filter::linear);
    turns_.assign(first_.size(), 0);  // where they stand may be new
    if (block_.id() == 0)
        block_ = {device_, "world's light in parts"};
}

void IslandLight::copy(std::size_t part, const Part& from)
{
    if (first_[part] < 0 || turns_[part] == from.turns_to_eye)
        return;
    turns_[part] = from.turns_to_eye;
    const glm::ivec3 size = from.light.size();
    device_->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);  // after the stores that filled it
    device_->CopyImageSubData(from.light.id(), GL_TEXTURE_3D, 0, 0, 0, 0, light_.id(),
                              GL_TEXTURE_3D, 0, 0, 0, first_[part], size.x, size.y, size.z);
}

void IslandLight::bind(const std::vector<Part>& parts, glm::dvec3 eye)
{
    shared::IslandLightParams params{};
    params.count = static_cast<int>(first_.size());
    params.inverse_size = 1.0f / glm::vec3(light_.size());
    for (std::size_t i = 0; i < first_.size(); ++i) {
        const Part& part = parts[i];
        copy(i, part);
        shared::IslandLattice& lattice = params.lattices[i];
        lattice.first = static_cast<float>(first_[i]);
        // What has no light has a place all the same.
        lattice.node_from_world =
            glm::mat4(part.lattice.node_from_world * glm::translate(glm::dmat4(1.0), eye));
        lattice.last = glm::vec3(part.lattice.count - 1);
    }
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, ISLAND_LIGHT_BLOCK, block_.id());
    light_.bind(WORLD_VOLUME_UNIT);
}

}  // namespace fumarole::light
