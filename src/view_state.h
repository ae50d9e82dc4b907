#pragma once

#include <memory>
#include <optional>

#include <fumarole/settings.h>
#include <fumarole/view.h>

#include "gl/device.h"
#include "gl/framebuffer.h"
#include "gl/texture.h"
#include "resolve/layers.h"
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
    gl::Texture full_scattering, full_transmittance;
    gl::Framebuffer framebuffer;
    /// Of transparents; none until a frame has some. Whoever asks for their number may outlive
    /// them.
    std::shared_ptr<transparent::FragmentLists> lists;

    /// The layers for frames in a mode: new ones if it was drawn in another before.
    resolve::Layers& layers_for(Settings::Mode wanted, const Toolbox& tools);
    /// Works the layers of a frame out.
    void draw(const PreparedFrame& frame, const Toolbox& tools);
    /// Whether the layers are those of a frame like this.
    [[nodiscard]] bool holds(const PreparedFrame& frame) const;
    /// The layers of a frame that it holds, at full size.
    LayerTextures full_size(const PreparedFrame& frame, const Toolbox& tools);
    void drop_full_size()
    {
        full_scattering = {};
        full_transmittance = {};
    }
};

}  // namespace fumarole
