#include "light/light_fade.h"

#include "shared/bindings.h"

namespace fumarole::light {

namespace {

const gl::Program& program(gl::ProgramCache& programs)
{
    return programs.get({"light/fade.comp"}, {});
}

}  // namespace

void LightFade::prepare(gl::ProgramCache& programs)
{
    program(programs);
}

void LightFade::begin(gl::Texture light, const Lattice& lattice)
{
    before_ = mixed_ ? std::move(mixed_) : std::move(light);
    mixed_ = {};
    lattice_ = lattice;
    frame_ = 0;
}

void LightFade::end()
{
    before_ = {};
    mixed_ = {};
}

void LightFade::go_on(const gl::Texture& now, const Lattice& lattice, int frames)
{
    const int layers = now ? now.size().z / lattice.count.z : 0;
    ++frame_;
    if (frame_ >= frames || layers != before_.size().z / lattice_.count.z) {
        end();
        return;
    }
    if (!mixed_)
        mixed_ = gl::Texture::make_3d(device_, "light that fades", now.size(), GL_RGBA16F,
                                      gl::Filter::linear);
    if (block_.id() == 0)
        block_ = {device_, "light that fades"};
    shared::LightFadeParams params{};
    params.before_from_node =
        glm::mat4(lattice_.node_from_world * glm::inverse(lattice.node_from_world));
    params.last_before = glm::vec3(lattice_.count - 1);
    params.share = static_cast<float>(frame_) / static_cast<float>(frames);
    params.inverse_size = 1.0f / glm::vec3(before_.size());
    params.layers = layers;
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, LIGHT_FADE_BLOCK, block_.id());
    before_.bind(FIELD_LIGHT_UNIT);
    now.bind(FIELD_WORLD_UNIT);
    device_->BindImageTexture(0, mixed_.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA16F);
    device_->UseProgram(program(programs_).id());
    const glm::uvec3 groups((lattice.count + VOLUME_GROUP - 1) / VOLUME_GROUP);
    device_->DispatchCompute(groups.x, groups.y, groups.z);
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

}  // namespace fumarole::light
