#include <fumarole/view.h>

#include <array>

#include <fumarole/errors.h>

#include "resolve/composite.h"
#include "view_state.h"

namespace fumarole {

View::View(std::unique_ptr<State> state) : state_{std::move(state)} {}
View::~View() = default;
View::View(View&&) noexcept = default;
View& View::operator=(View&&) noexcept = default;

void View::reset_history()
{
    state_->last_layer = {};
    if (state_->layers != nullptr)
        state_->layers->reset_history();
}

const char* View::history() const
{
    return state_->layers != nullptr ? state_->layers->history_use() : "";
}

OwnLayers View::own_layers() const
{
    return state_->drawn ? state_->layers->own() : OwnLayers{};
}

VolumeAtNames View::volume_at() const
{
    if (!state_->volume_at)
        throw Error("View::volume_at: the view's last frame did not ask for it; say in "
                    "Frame::transparents of the frame that composite() gets where the host draws "
                    "its own");
    return *state_->volume_at;
}

void View::State::publish_volume(resolve::Layers* seen, const PreparedFrame& frame)
{
    if (volume_at_block.id() == 0)
        volume_at_block = {*device, "volume at any depth"};
    const resolve::HostVolume volume =
        seen != nullptr ? seen->host_volume(frame) : resolve::HostVolume{};
    volume_at_block.write(volume.params);
    VolumeAtNames& names = volume_at.emplace();
    names.block = volume_at_block.id();
    for (std::size_t i = 0; i < volume.textures.size(); ++i)
        if (volume.textures.at(i) != nullptr)
            names.textures.at(i) = volume.textures.at(i)->id();
}

resolve::Layers& View::State::layers_for(Settings::Mode wanted, const Toolbox& tools)
{
    if (layers == nullptr || mode != wanted) {
        drawn.reset();
        volume_at.reset();
        layers.reset();  // one mode's textures at a time
        mode = wanted;
        layers = resolve::make_layers(mode, tools);
    }
    return *layers;
}

void View::State::draw(const PreparedFrame& frame, const Toolbox& tools)
{
    resolve::Layers& wanted = layers_for(frame.settings.mode, tools);
    drawn.reset();  // should this throw
    wanted.draw(frame);
    drawn = {frame.picture_size, frame.settings};
    const LayerChoice& choice = frame.layer_choice;
    const bool was_free = keeps_history && choice.reason != LayerReason::history;
    last_layer = {frame.picture_size, frame.life_id, was_free ? choice.scale : 0};
}

bool View::State::holds(const PreparedFrame& frame) const
{
    return drawn == Drawn{frame.picture_size, frame.settings};
}

LayerTextures View::State::full_size(const PreparedFrame& frame, const Toolbox& tools)
{
    const gl::Device& gl = tools.device;
    const glm::ivec2 size = frame.picture_size;
    if (glm::ivec2(full_scattering.size()) != size) {
        const auto make = [&](const char* label) {
            return gl::Texture::make_2d(gl, label, size, GL_RGBA32F, gl::Filter::nearest);
        };
        full_scattering = make("scattering at full size");
        full_transmittance = make("transmittance at full size");
        framebuffer = {gl, "layer at full size"};
    }
    const auto fill = [&](const gl::Texture& texture, resolve::Layer layer, float nothing) {
        framebuffer.attach_color({texture.view()});
        framebuffer.bind(size);
        const std::array<GLfloat, 4> value{nothing, nothing, nothing, 1};
        gl->ClearNamedFramebufferfv(framebuffer.id(), GL_COLOR, 0, value.data());
        resolve::draw_layer(
            tools, *layers,
            resolve::make_canvas(tools, framebuffer, texture.view(), frame.settings), frame, layer);
    };
    fill(full_scattering, resolve::Layer::scattering, 0);
    fill(full_transmittance, resolve::Layer::transmittance, 1);
    return {full_scattering.view(), full_transmittance.view()};
}

}  // namespace fumarole
