#pragma once

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "light/field_lattice.h"
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

    /// Compiles what a fade needs.
    static void prepare(gl::ProgramCache& programs);

    /// Fades from what is shown, `light` unless it fades already, at the nodes of `lattice`.
    void begin(gl::Texture light, const Lattice& lattice);
    void end();
    [[nodiscard]] bool is_on() const { return static_cast<bool>(before_); }

    /// A frame of `frames` further on, to `now` with as many coefficients. Ends after the last.
    void go_on(const gl::Texture& now, const Lattice& lattice, int frames);

    /// What is to be looked up where `now` would be without a fade.
    [[nodiscard]] const gl::Texture& shown(const gl::Texture& now) const
    {
        return mixed_ ? mixed_ : now;
    }

private:
    const gl::Device& device_;
    gl::ProgramCache& programs_;
    gl::UniformBuffer<shared::LightFadeParams> block_;
    gl::Texture before_, mixed_;
    Lattice lattice_;  ///< of before_
    int frame_ = 0;
};

}  // namespace fumarole::light
