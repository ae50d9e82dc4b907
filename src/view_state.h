#pragma once

#include <memory>
#include <optional>

#include <fumarole/settings.h>
#include <fumarole/view.h>

#include "gl/binding_guard.h"
#include "gl/buffer.h"
#include "gl/device.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "resolve/layers.h"
#include "shared/host_transparent_params.h"
#include "shared/volume_at_params.h"
#include "transparent/fine_target.h"
#include "transparent/fragment_lists.h"

namespace fumarole {

/// What a View owns.
struct View::State {
    /// A frame that the layers were worked out for.
    struct Drawn {
        glm::ivec2 size{0};
        FrameSettings settings;
        bool operator==(const Drawn&) const = default;
    };

    std::shared_ptr<const gl::Device> device;  ///< first: it outlives the textures
    const void* owner = nullptr;               ///< parts of the Renderer that made it
    bool keeps_history = true;
    Settings::Mode mode{};
    std::unique_ptr<resolve::Layers> layers;
    std::optional<Drawn> drawn;
    /// The last frame's layer, if its size was left open: the next one's is chosen by it.
    struct Layer {
        glm::ivec2 picture_size{0};
        std::uint64_t life_id = 0;
        int scale = 0;
    };
    Layer last_layer;
    gl::Texture full_scattering, full_transmittance;
    gl::Framebuffer framebuffer;
    /// Of transparents; none until a frame has some. Whoever asks for their number may outlive
    /// them.
    std::shared_ptr<transparent::FragmentLists> lists;
    /// Fragments of the host's in them that no frame has laid over its picture yet.
    struct HostFragments {
        glm::ivec2 size{0};
        Settings::Format format{};
        std::unique_ptr<gl::BindingGuard> bindings;  ///< while the host draws
    };
    std::optional<HostFragments> host_fragments;
    bool lists_have_hosts = false;  ///< the last frame's had some
    /// Of transparents in order, which have no lists: what panes add, and a picture.
    transparent::FineTarget pane_layer{"what panes add", {}, {}};
    transparent::FineTarget transparent_sum{"picture with transparents", {}, {}};
    gl::Texture media_mask;  ///< where transparents look media up
    gl::UniformBuffer<shared::HostTransparentParams> host_block;
    gl::UniformBuffer<shared::VolumeAtParams> volume_at_block;
    std::optional<VolumeAtNames>
        volume_at;  ///< names of volume_at() of the last frame, if it asked for it

    /// Lets go of what transparents have needed, where a frame has none.
    void drop_transparents()
    {
        lists.reset();
        lists_have_hosts = false;
        pane_layer.drop();
        transparent_sum.drop();
        media_mask = {};
    }
    /// The layers for frames in a mode: new ones if it was drawn in another before.
    resolve::Layers& layers_for(Settings::Mode wanted, const Toolbox& tools);
    /// Works the layers of a frame out.
    void draw(const PreparedFrame& frame, const Toolbox& tools);
    /// Whether the layers are those of a frame like this.
    [[nodiscard]] bool holds(const PreparedFrame& frame) const;
    /// Has volume_at name what the layers hold of a frame. @param seen null: no medium is in view
    void publish_volume(resolve::Layers* seen, const PreparedFrame& frame);
    /// The layers of a frame that it holds, at full size.
    LayerTextures full_size(const PreparedFrame& frame, const Toolbox& tools);
    void drop_full_size()
    {
        full_scattering = {};
        full_transmittance = {};
    }
};

}  // namespace fumarole
