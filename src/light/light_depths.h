#pragma once

#include <optional>
#include <string>
#include <vector>

#include "gl/texture.h"
#include "light/lattice.h"
#include "light/light_set.h"
#include "light/marched_extinction.h"
#include "light/volume_tools.h"
#include "medium/media_set.h"
#include <fumarole/settings.h>

namespace fumarole::light {

/// The optical depth of the media that have no closed form, from each node of a lattice towards
/// each light: a layer a light, in place of what would be marched at each sample. The lattice
/// follows the voxels of the largest grid, sheared as those may be.
class LightDepths {
public:
    /// @param extinction is filled where it is needed, and dropped once it is not
    LightDepths(VolumeTools& tools, MarchedExtinction& extinction)
        : tools_{tools}, extinction_{extinction}
    {
    }

    /// Fills what is not there yet of a scene that has lights and marched media; where lights alone
    /// have moved, over several frames if the settings ask for it. Changes GL state.
    /// @param frame of the marched media
    void set(const SceneSettings& settings, const medium::VoxelFrame& frame,
             medium::MediaSet& media, LightSet& lights);
    void clear();

    [[nodiscard]] bool has_more() const { return refill_.has_value(); }
    /// Fills a frame's part of what has_more(). @returns whether what frames look up is another now
    bool go_on(medium::MediaSet& media);
    /// Number of times that it was.
    [[nodiscard]] int refills() const { return refills_; }

    explicit operator bool() const { return static_cast<bool>(depths_); }
    /// The lines that glsl/scene/light_volumes.glsl needs.
    [[nodiscard]] gl::Defines defines() const;
    /// Puts what looks them up into a block.
    void write_params(shared::LightVolumesParams& params, glm::dvec3 eye) const;
    void bind() const { depths_.bind(DEPTH_VOLUME_UNIT); }

    /// Puts four lights' depths into a texel too where that saves fetches, if it isn't done.
    void pack(glm::dvec3 eye);
    [[nodiscard]] bool has_packed() const { return static_cast<bool>(packed_depths_); }
    /// Binds those in their place, for passes of kPackedDepths.
    void bind_packed() const { packed_depths_.bind(DEPTH_VOLUME_UNIT); }

    /// Nodes along each axis; 0: there are no depths.
    [[nodiscard]] glm::ivec3 nodes() const { return depths_ ? lattice_.count : glm::ivec3(0); }
    /// Metres along the world's axes that a lookup of a sun's depths may mix places over; 0: none.
    [[nodiscard]] glm::dvec3 blur() const;
    [[nodiscard]] std::string describe() const;
    /// Layers that were filled so far.
    [[nodiscard]] int layers_filled() const { return layers_filled_; }

private:
    /// What they were filled from besides the lights. All of it may be moved as a whole with the
    /// lattice, and they stay.
    struct Key {
        std::vector<medium::Extinction> media;  ///< those that are marched
        LatticePlace lattice;
        bool colored = false;
    };
    /// Depths towards lights that have moved, and that take the place of depths_ once all are
    /// filled.
    struct Refill {
        gl::Texture depths;
        std::vector<LightPosition> lights;
        std::vector<int> layers;  ///< layers of those lights that are to be filled
        int a_frame = 0;          ///< slices that a frame fills
        std::size_t layer = 0;    ///< into layers: the one that is being filled
        int slices = 0;           ///< number of that layer's slices that are filled
    };
    /// Where the lights that are wanted are among those that are filled.
    struct Matches {
        std::vector<int> layers;  ///< each light's layer; -1: it has none
        bool in_place = true;     ///< each that has one has its own
        bool all = true;          ///< each has one
        bool placed = false;      ///< some that has none is not far
    };

    static bool is_moved(const Key& then, const Key& now);
    [[nodiscard]] bool is_same(const LightPosition& a, const LightPosition& b) const;
    /// @returns whether what is filled is right there but for the lights
    bool set_lattice(const SceneSettings& settings, const medium::VoxelFrame& frame,
                     const medium::MediaSet& media, int lights);
    void drop();
    [[nodiscard]] Matches match_lights(bool same) const;
    void fill_missing(const Matches& matches, medium::MediaSet& media, LightSet& lights);
    void begin_refill();
    void fill_more(glm::dvec3 eye);
    [[nodiscard]] gl::Texture make(const char* label, int layers) const;
    [[nodiscard]] int slices_of(const LightPosition& light) const;
    void fill(const gl::Texture& depths, int layer, const LightPosition& light, int first_slice,
              int slices, glm::dvec3 eye);
    void bind_block(glm::dvec3 eye) const;
    [[nodiscard]] shared::SunColumns columns_of(const LightPosition& sun) const;
    [[nodiscard]] shared::SunLookup lookup_of(const shared::LightVolumesParams& params,
                                              const shared::SunColumns& columns, int layer,
                                              glm::dvec3 eye) const;
    /// The first light of each layer of packed depths, and how many it has; none where a fetch
    /// would have one alone, or where depths are coloured.
    [[nodiscard]] std::vector<glm::ivec2> packs() const;

    VolumeTools& tools_;
    MarchedExtinction& extinction_;
    Lattice lattice_;
    glm::dmat3 voxels_from_node_{1.0};  ///< voxels of the largest grid
    Key key_;
    gl::Texture depths_;
    // Where lights are, from the lattice's first node, whatever their colour: one that flickers
    // throws the same shadow.
    std::vector<LightPosition> lights_;  ///< the light of each layer
    std::vector<LightPosition> wanted_;  ///< as the scene has them now
    std::size_t placed_ = 0;             ///< number of points and spots among the lights of depths_
    /// Depths as a frame looks them up where several lights have places: those share the lattice,
    /// so that one fetch may have four. Made of depths_, which the lights that move go on to
    /// change.
    gl::Texture packed_depths_;
    bool packed_ = false;  ///< packed_depths_ is what depths_ is
    gl::Defines fill_defines_;
    std::optional<Refill> refill_;
    int refill_frames_ = 1;  ///< SceneSettings::shadow_fill
    int refills_ = 0, layers_filled_ = 0;
    std::optional<double> ms_;  ///< time that filling them took [ms], if it was measured
};

}  // namespace fumarole::light
