#pragma once

#include "light/lattice.h"
#include "light/light_set.h"
#include "light/volume_tools.h"
#include "medium/media_set.h"

namespace fumarole::light {

/// The extinction of the media that are marched, at the nodes of a lattice. Volumes of light are
/// filled from it, so that they fetch from one dense texture whatever the media are; it is freed
/// again.
class MarchedExtinction {
public:
    explicit MarchedExtinction(VolumeTools& tools) : tools_{tools} {}

    /// Tells whether one number a node is enough, and the colour that it then stands for. Before
    /// all else.
    void set_color(const medium::MediaSet& media);
    /// Changes GL state, and binds media and lights for an eye amid the lattice.
    void fill(const medium::VoxelFrame& frame, medium::MediaSet& media, LightSet& lights);
    /// Has what was filled be where the media have moved to.
    void move_to(const medium::VoxelFrame& frame) { lattice_ = lattice_of(frame); }
    void drop() { volume_ = {}; }

    explicit operator bool() const { return static_cast<bool>(volume_); }
    [[nodiscard]] const gl::Texture& volume() const { return volume_; }
    [[nodiscard]] bool is_colored() const { return colored_; }
    /// Puts where it is into the block.
    void write_params(glm::dvec3 eye) const;
    /// The lines of a shader that fills a volume from the media: theirs, and `own`.
    [[nodiscard]] gl::Defines fill_defines(const medium::MediaSet& media,
                                           const gl::Defines& own) const;
    [[nodiscard]] int fills() const { return fills_; }

private:
    [[nodiscard]] Lattice lattice_of(const medium::VoxelFrame& frame) const;

    VolumeTools& tools_;
    bool colored_ = false;
    Lattice lattice_;
    gl::Texture volume_;
    int fills_ = 0;
};

}  // namespace fumarole::light
