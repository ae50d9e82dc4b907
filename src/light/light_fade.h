#pragma once

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/lattice.h"
#include "shared/light_fade_params.h"

namespace fumarole::light {

/// Light at the nodes of a lattice, as coefficients, that fades from what was filled before to what
/// takes its place: what takes frames to fill would be seen to come all at once.
class LightFade {
public:
    LightFade(const gl::Device& device, gl::ProgramCache& programs)
        : device_{device}, programs_{programs}
    {
    }

    /// Compiles what mixed() needs.
    static void prepare(gl::ProgramCache& programs);

    /// Light and the lattice that it is filled for.
    struct Filled {
        const gl::Texture& light;
        const Lattice& lattice;
    };

    /// Fades over so many frames from `light`, which `now` takes the place of; from what both make
    /// where it fades already.
    void begin(gl::Texture light, const Lattice& lattice, int frames);
    /// A frame further on. Ends after the last.
    void go_on();
    void end();
    /// What it fades from is moved by so many metres.
    void move(glm::dvec3 by);
    [[nodiscard]] bool is_on() const { return static_cast<bool>(before_); }

    /// Binds what light/fade.glsl needs to fade to `now`. @returns its lines
    gl::Defines bind(const Filled& now);
    /// What is to be looked up in the place of `now`.
    const gl::Texture& mixed(const Filled& now);

private:
    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::UniformBuffer<shared::LightFadeParams> block_;
    gl::Texture before_, mixed_;
    bool is_mixed_ = false;  ///< mixed_ is this frame's
    Lattice lattice_;        ///< of before_
    int frame_ = 0, frames_ = 1;
};

}  // namespace fumarole::light
