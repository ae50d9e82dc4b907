#pragma once

#include <array>
#include <cstdint>
#include <memory>

#include <fumarole/export.h>
#include <fumarole/gl.h>
#include <fumarole/host_glsl.h>

namespace fumarole {

/// A frame's two layers as textures: color * transmittance + scattering is the composite. They
/// belong to the view, and hold until its next frame.
struct LayerTextures {
    gl::TextureView scattering;     ///< RGB: radiance of the media towards the eye [W/m^2/sr]
    gl::TextureView transmittance;  ///< RGB: what the media let through of the scene, 0..1

    explicit operator bool() const { return static_cast<bool>(scattering); }
};

/// A view's own layers, as they are before they are looked up at a pixel's depth.
struct OwnLayers {
    /// Of a march: 2-D, a texel for each ray, with `guard` texels around the picture on each side.
    /// Of froxels: 3-D, what lies in front of each froxel's far side. Its alpha has transmittance
    /// with `grey`, and that of red where `transmittance` has two channels, for green and blue.
    gl::TextureView scattering;
    gl::TextureView transmittance;  ///< likewise; empty if `grey`
    gl::TextureView depth;  ///< depth of a march: view_z of the scene [m] as each texel took it
    bool grey = false;      ///< true if transmittance is one number for all channels
    int guard = 0;          ///< width of the border round the picture [texels]
    int scale = 1;          ///< edge of a texel [pixels]
};

/// What shaders with volume_at_glsl() of <fumarole/host_glsl.h> read, by the GL's names. It belongs
/// to the view, and holds until its next frame.
struct VolumeAtNames {
    std::uint32_t block = 0;  ///< buffer for VolumeAtBindings::block
    /// Textures for the units from VolumeAtBindings::first_unit on (glBindTextures); 0: none.
    std::array<std::uint32_t, kVolumeAtUnits> textures{};
};

/// One of the views that a host draws, as a player's, a mirror's or an eye's: its layers at its
/// size, and what is kept of them from frame to frame. Its textures are made by its first frame,
/// and anew only by one of another size or with settings that ask for others. Views stand side by
/// side, each in a mode of its own.
///
/// Made by Renderer::make_view(), for the frames of that renderer alone, which it may outlive. The
/// context is to be current where it dies.
class FUMAROLE_API View {
public:
    enum class History {
        kept,  ///< frames build on those before them where settings ask for it
        none,  ///< each is a picture on its own
    };

    ~View();
    View(View&&) noexcept;
    View& operator=(View&&) noexcept;

    /// Lets the next frame begin anew. A cut, another scene and other settings are seen without it.
    void reset_history();

    /// What the last frame did with those before it, and why; "" where nothing is kept.
    [[nodiscard]] const char* history() const;

    /// The layers of the last frame as they were worked out; empty where none was.
    [[nodiscard]] OwnLayers own_layers() const;

    /// What the media do before any depth of the last composite()'s frame, for the host's shaders.
    /// @throws Error if that frame's Frame::transparents did not ask for it
    [[nodiscard]] VolumeAtNames volume_at() const;

private:
    friend class Renderer;
    struct State;
    explicit View(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

}  // namespace fumarole
