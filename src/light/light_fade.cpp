#include "light/light_fade.h"

#include <glm/gtc/matrix_transform.hpp>

#include "shared/bindings.h"

namespace fumarole::light {

void LightFade::prepare(gl::ProgramCache& programs)
{
    for (const gl::Defines& variant : {gl::Defines{}, gl::Defines{{"kStays", ""}}})
        programs.get({"light/fade.comp"}, variant);
}

void LightFade::begin(gl::Texture light, const Lattice& lattice, int frames)
{
    if (is_on()) {
        mixed({light, lattice});
        before_ = std::move(mixed_);
    } else {
        before_ = std::move(light);
    }
    lattice_ = lattice;
    frame_ = 0;
    frames_ = frames;
    is_mixed_ = false;
}

void LightFade::go_on()
{
    ++frame_;
    is_mixed_ = false;
    if (frame_ >= frames_)
        end();
}

void LightFade::end()
{
    before_ = {};
    mixed_ = {};
}

void LightFade::move(glm::dvec3 by)
{
    lattice_.node_from_world = glm::translate(lattice_.node_from_world, -by);
    is_mixed_ = false;
}

gl::Defines LightFade::bind(const Filled& now)
{
    if (block_.id() == 0)
        block_ = {device_, "light that fades"};
    shared::LightFadeParams params{};
    params.before_from_node =
        glm::mat4(lattice_.node_from_world * glm::inverse(now.lattice.node_from_world));
    params.last_before = glm::vec3(lattice_.count - 1);
    params.share = static_cast<float>(frame_) / static_cast<float>(frames_);
    params.inverse_size = 1.0f / glm::vec3(before_.size());
    params.layers = now.light.size().z / now.lattice.count.z;
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, LIGHT_FADE_BLOCK, block_.id());
    before_.bind(FIELD_LIGHT_UNIT);
    if (lattice_.count == now.lattice.count &&
        lattice_.node_from_world == now.lattice.node_from_world)
        return {{"kStays", ""}};
    return {};
}

const gl::Texture& LightFade::mixed(const Filled& now)
{
    if (!is_on())
        return now.light;
    if (is_mixed_)
        return mixed_;
    if (!mixed_ || mixed_.size() != now.light.size())
        mixed_ = gl::Texture::make_3d(device_, "light that fades", now.light.size(), GL_RGBA16F,
                                      gl::Filter::linear);
    const gl::Defines variant = bind(now);
    now.light.bind(FIELD_WORLD_UNIT);
    device_->BindImageTexture(0, mixed_.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    device_->UseProgram(programs_.get({"light/fade.comp"}, variant).id());
    const glm::uvec3 groups((now.lattice.count + VOLUME_GROUP - 1) / VOLUME_GROUP);
    device_->DispatchCompute(groups.x, groups.y, groups.z);
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    is_mixed_ = true;
    return mixed_;
}

}  // namespace fumarole::light
