#pragma once

#include <array>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "gl/buffer.h"
#include "gl/program.h"
#include "gl/texture.h"
#include "medium/glow.h"
#include "medium/glow_cells.h"
#include "medium/grid_layout.h"
#include "medium/media_source.h"
#include "medium/occupancy.h"
#include "shared/blackbody.h"
#include "shared/medium_params.h"
#include <fumarole/bounds.h>
#include <fumarole/scene.h>
#include <fumarole/settings.h>

// The media of a scene on the GPU, and the variant of the shaders that their kinds ask for.

namespace fumarole::medium {

/// What the media of a scene have, and so what a shader must do for them.
struct MediaTraits {
    int media = 0;          ///< number of media that scatter, absorb or emit at all
    int heterogeneous = 0;  ///< number of those that change from place to place
    int marched = 0;  ///< number of those whose optical depth towards a light has no closed form
    int bricked_grids = 0;
    int islands = 0;  ///< parts of media that lie far apart: volumes of light would be too coarse
    int noise_grids = 0;  ///< noises that are read from a grid
    int noise_turns = 0;  ///< turns of the loops over noise's octaves, at one point
    bool colored_extinction = false;
    bool colored_density = false;
    bool emission = false;
    bool blackbody = false;  ///< some of it is a blackbody's
    bool mixed_g = false;
    bool isotropic = true;
    bool scatters = false;
    float g = 0;       ///< g of all media that scatter, unless they differ
    float most_g = 0;  ///< |g| of the medium that scatters the most to one side
};

/// A frame to lay volumes out in that follow the media: the voxels of the largest marched medium
/// (of noise, the cells of its last octave; of large constant tiles, 64 cells along the longest
/// edge; where none is marched, 96 along each edge of all).
struct VoxelFrame {
    glm::dmat4 voxel_from_world{1.0};
    Bounds marched;      ///< voxels: what the marched media fill
    Bounds scattering;   ///< voxels: what the media fill that scatter
    bool tiles = false;  ///< they are cells of large constant tiles
};

/// What the extinction of one medium depends on, and nothing else of it: media that differ in g,
/// emission, tint, or albedo at the same sigma_t have equal ones.
struct Extinction {
    std::shared_ptr<const VoxelGrid> grid;  ///< null where the profile is evaluated
    Layout layout = Layout::automatic;      ///< as asked for the grid
    Storage storage = Storage::automatic;   ///< as asked for the grid
    MediumSource::Profile profile{};
    NoiseProfile noise;    ///< its drift left out
    float per_height = 0;  ///< 1 / scale height [1/m]
    glm::vec3 sigma_t{0};  ///< [1/m], times the field
    bool marched = false;  ///< it has no closed form
    /// Points that pin where the field lies, metres, world: a corner and the ends of three edges,
    /// the origin of its profile, which drift moves.
    std::array<glm::dvec3, 5> place{};
};

/// Whether two points are one to within `tolerance` [m] and what rounding leaves so far out.
bool is_same_place(glm::dvec3 a, glm::dvec3 b, double tolerance);

/// Whether `now` is `then` moved by `moved` [m] as a whole, to within `tolerance` [m].
bool is_moved(const Extinction& then, const Extinction& now, glm::dvec3 moved, double tolerance);
bool are_moved(const std::vector<Extinction>& then, const std::vector<Extinction>& now,
               glm::dvec3 moved, double tolerance);

/// What of the world a part of a medium may fill, and how fine it is there.
struct Occupied {
    glm::dmat4 world_from_box{1.0};
    std::vector<OccupiedBox> boxes;  ///< most: extinction [1/m]
    double detail = 0;               ///< metres within which it changes; infinite: nowhere
};

/// What of the media a picture of fewer rays leaves out.
struct MediaDetail {
    static constexpr double kNowhere = std::numeric_limits<double>::infinity();
    double boxes = kNowhere;  ///< metres within which boxes change, as they do without a grid
    double grids =
        kNowhere;  ///< metres within which what is seen of a grid changes: a voxel or less
    bool has_outline = false;  ///< some end at a face, and not in a grid's zeros
};

class MediaSet {
public:
    explicit MediaSet(const gl::Device& device) : device_{device}, block_{device, "media"} {}

    /// Uploads the grids that are not there yet (known by pointer, layout and storage) and frees
    /// those that the scene no longer has. With settings.noise_grid a noise that does not drift
    /// becomes a grid where that is small enough and a texture unit is free for it.
    /// @throws Error if a grid or their number is too large for this GL.
    void set(const Scene& scene, const SceneSettings& settings);

    /// Begins to send the grids of a scene that are not there, for a later set() of it, and forgets
    /// those that were on their way to another. What set() finds half sent it sends the rest of.
    /// @throws Error as set()
    void begin_sending(const Scene& scene, const SceneSettings& settings);
    /// Sends a part. @param row a row of texels even if that is more than `most` bytes
    /// @returns bytes
    std::uint64_t send(std::uint64_t most, bool row);
    /// Whether some of what was begun is not there yet.
    [[nodiscard]] bool is_sending() const;
    /// Whether all grids of a scene are: set() would send nothing of them.
    [[nodiscard]] bool has_grids(const Scene& scene, const SceneSettings& settings) const;

    /// Leaves nothing: what is right after set() has thrown.
    void clear();

    [[nodiscard]] const MediaTraits& traits() const { return traits_; }
    [[nodiscard]] bool empty() const { return media_.empty(); }
    /// What is not 0 of all media, world space.
    [[nodiscard]] Bounds bounds() const;
    /// Of bounds() the faces at which a box ends, with all of its density; others are far off.
    [[nodiscard]] Bounds ends() const;

    /// The media's boxes, or, of grids, those of their bricks that are not empty; few enough to be
    /// projected each frame; most: of the channel that is dimmed most, infinite of what glows.
    [[nodiscard]] const std::vector<Occupied>& occupied() const { return occupied_; }
    /// Another whenever they have changed.
    [[nodiscard]] std::uint64_t occupied_id() const { return occupied_id_; }
    [[nodiscard]] MediaDetail detail() const;

    [[nodiscard]] VoxelFrame voxel_frame() const;
    /// The same of each part that lies far from the others, of all media that are there.
    [[nodiscard]] std::vector<VoxelFrame> island_frames() const;
    /// The colour that all marched media's extinction has, its mean 1; nothing if they differ.
    [[nodiscard]] std::optional<glm::vec3> marched_color() const;
    /// The colour that all media's extinction has, its brightest channel 1; nothing if they differ.
    [[nodiscard]] std::optional<glm::vec3> extinction_color() const;
    /// Of all media where they have their full coefficients, each channel 0..1.
    [[nodiscard]] glm::vec3 mean_albedo() const;
    /// Share of their extinction that is scattered straight on, as glsl/light/forward_peak.glsl
    /// has it, 0..1: the most of any that is not thin.
    [[nodiscard]] float straight_on() const;
    /// Whether that counts as light that goes on where the media scatter it.
    void split_forward_peaks(bool split);
    [[nodiscard]] bool splits_forward_peaks() const { return peak_g_.has_value(); }
    /// Whether those that scatter are all marched: a point that does is in the volume of their
    /// optical depth.
    [[nodiscard]] bool marched_alone() const;
    /// Of each medium what it glows, if all of that comes from a place that is no longer than
    /// `most` [m]; none for others. Kept until the next set().
    [[nodiscard]] const std::vector<std::optional<SmallGlow>>& small_glows(double most);
    /// Leaves what these media glow out where media are bound for light that is carried: it is
    /// that of lights. In the order of small_glows(); empty: none.
    void split_off(std::vector<bool> media)
    {
        split_off_ = std::move(media);
        carried_glow_.reset();
    }
    [[nodiscard]] const std::vector<bool>& split_off() const { return split_off_; }
    /// Whether some medium glows of which it is not left out.
    [[nodiscard]] bool carries_glow() const;
    /// What is not left out, of all media, and the box that it comes from [m, world]. Kept until
    /// the next set().
    struct CarriedGlow {
        Glow glow;
        Bounds bounds;
    };
    [[nodiscard]] const CarriedGlow& carried_glow();

    /// Of all media that dim light, in the scene's order.
    [[nodiscard]] std::vector<Extinction> extinction() const;

    /// What is kept of each medium that dims or glows, of its density where it has a flame too;
    /// most: the mean of the channels.
    [[nodiscard]] std::vector<Occupied> kept_boxes() const;

    /// Optical depth through their bounds, the mean of the three axes, from what their boxes hold
    /// at most. @param part metres, world: of what lies there alone
    [[nodiscard]] double mean_optical_depth(const Bounds* part = nullptr) const;
    /// The same and the albedo, of all media first, and then, of several, of each by itself,
    /// through its own bounds: a dense box in wide haze is a small part of what the mean of both
    /// has.
    struct Thickness {
        double optical_depth = 0;
        glm::vec3 albedo{0};
        Bounds bounds;  ///< metres, world
    };
    [[nodiscard]] std::vector<Thickness> thicknesses(const Bounds* part = nullptr) const;
    /// Optical depth along the edge of a voxel of the marched media where they dim, the mean of the
    /// channels, from what their boxes hold at most, weighed by it.
    [[nodiscard]] double voxel_optical_depth(const VoxelFrame& frame) const;

    /// The lines that glsl/scene/media.glsl needs.
    [[nodiscard]] gl::Defines defines() const;

    /// Binds textures and block for an eye at `eye` (metres, world).
    /// @param carried for light that is carried from place to place
    void bind(glm::dvec3 eye, bool carried = false);

    /// One line a grid: its layout, storage and bytes.
    [[nodiscard]] std::vector<std::string> describe() const;
    /// Grids sent to the GPU so far.
    [[nodiscard]] int uploads() const { return uploads_; }
    /// Likewise bytes of them.
    [[nodiscard]] std::uint64_t sent_bytes() const { return sent_bytes_; }
    [[nodiscard]] int texture_units() const { return static_cast<int>(placed_.size()) * 2; }

private:
    struct Grid {
        std::shared_ptr<const VoxelGrid> source;
        Layout asked_layout = Layout::automatic;
        Storage asked_storage = Storage::automatic;
        GridLayout plan;  ///< its texels and pages emptied after the upload
        gl::Texture texels, pages;
        std::size_t texel_rows = 0,
                    page_rows = 0;  ///< number of rows of texels and of pages that are sent

        [[nodiscard]] bool is(const std::shared_ptr<const VoxelGrid>& grid,
                              const SceneSettings& settings) const
        {
            return source == grid && asked_layout == settings.layout &&
                   asked_storage == settings.storage;
        }
        [[nodiscard]] bool is_sent() const
        {
            return texel_rows == texels.rows() && (!pages || page_rows == pages.rows());
        }
    };
    /// Grid of a noise, kept from scene to scene: it takes tens of milliseconds.
    struct NoiseGrid {
        NoiseProfile noise;
        Bounds bounds;
        std::shared_ptr<const VoxelGrid> grid;  ///< null: it would be too large
    };
    /// A grid as one medium places it.
    struct PlacedGrid {
        int texture = 0;                   ///< into grids_
        glm::dmat4 index_from_world{1.0};  ///< voxels from the texture's first, from metres
        auto operator==(const PlacedGrid& other) const
        {
            return texture == other.texture && index_from_world == other.index_from_world;
        }
    };
    struct Entry {
        MediumSource::Profile profile = MediumSource::Profile::grid;
        MediumSource::Depth depth = MediumSource::Depth::none;
        int density = -1, emission = -1, tint = -1, temperature = -1;  ///< into placed_
        glm::dmat4 bounds_from_world{1.0};
        Bounds bounds;        ///< bounds in the space of bounds_from_world
        Bounds world_bounds;  ///< metres
        shared::MediumParams params{};
        float least_tint = 1;  ///< of what it scatters, what its tint leaves nearly everywhere
        bool is_box = false;   ///< true if it is a box with bounds in world space, whether it is
                               ///< read from a grid or not
        NoiseProfile noise;
        bool is_small = false;  ///< beside all media: steps as long as these ask for would miss it
        bool tiles = false;     ///< its grid is a few constant tiles, larger than its voxels matter
        std::vector<Bounds>
            islands;  ///< parts that lie apart, in the space of bounds; none where nothing does
        double height = 0;  ///< z0 of an exponential height profile [m]

        /// Of a box: metres within which its profile changes, and its largest coefficient.
        [[nodiscard]] double detail() const;
        [[nodiscard]] float thickest() const;
        [[nodiscard]] bool is_marched() const { return depth == MediumSource::Depth::marched; }
        [[nodiscard]] bool is_noise() const { return profile == MediumSource::Profile::noise; }
        [[nodiscard]] bool glows() const
        {
            return params.emission != glm::vec3(0.0f) || temperature >= 0;
        }
        [[nodiscard]] bool scatters() const { return params.sigma_s != glm::vec3(0.0f); }
        /// Share of its extinction that is scattered straight on, in the channel that scatters the
        /// least.
        [[nodiscard]] float straight_on() const;
        /// Of a box without a grid: what of its coefficients it has at a height of its own space.
        [[nodiscard]] double at_height(double z) const
        {
            return std::exp(-(z - height) * static_cast<double>(params.inverse_scale_height));
        }
        /// The value of its temperature grid up to which nothing is seen of it.
        [[nodiscard]] float dark() const
        {
            return shared::kDarkKilokelvin / params.kilokelvin_per_unit;
        }
    };

    /// MediaSet::straight_on(), of media whose optical depth has a closed form and of others: these
    /// have one volume for all, and so the least of any.
    struct StraightOn {
        float closed = 0, marched = 0;
        float g = 0;  ///< g of the medium of which it is the most
    };
    [[nodiscard]] StraightOn straight_on_by_depth() const;

    [[nodiscard]] int most_grids() const;
    int place(const std::shared_ptr<const VoxelGrid>& grid, const glm::dmat4& world_from_grid,
              const SceneSettings& settings);
    int upload(const std::shared_ptr<const VoxelGrid>& grid, const SceneSettings& settings);
    /// A grid with its textures, in which there is nothing yet.
    [[nodiscard]] Grid make_grid(const std::shared_ptr<const VoxelGrid>& grid,
                                 const SceneSettings& settings) const;
    std::uint64_t send(Grid& grid, std::uint64_t most, bool row);
    void add(const GridMedium& medium, const SceneSettings& settings);
    void add(const BoxMedium& medium);
    [[nodiscard]] std::shared_ptr<const VoxelGrid> noise_grid(const Entry& box);
    void read_noise_from_grids(const SceneSettings& settings);
    [[nodiscard]] const GridLayout& layout_of(int placed) const;
    [[nodiscard]] const VoxelGrid& grid_of(int placed) const;
    /// Metres, world: beyond which a medium doesn't glow.
    [[nodiscard]] Bounds glow_bounds(const Entry& medium) const;
    /// A grid that glows, and what a metre adds where it has a value.
    struct GlowingGrid {
        int placed = -1;
        std::function<glm::dvec3(glm::dvec3)> radiance;
    };
    class WorldLookup;
    [[nodiscard]] std::vector<GlowingGrid> glowing_grids(const Entry& medium) const;
    [[nodiscard]] Glow glow_of_entry(const Entry& medium) const;
    [[nodiscard]] GlowCells glow_cells_of(const Entry& medium, const Bounds& bounds) const;
    /// The voxel that shaders count from in a grid whose pages are a tree: the first of the page
    /// that the eye is in. 0 for others.
    [[nodiscard]] glm::dvec3 base_voxel(int placed, glm::dvec3 eye) const;
    [[nodiscard]] double box_detail(const Entry& box) const;
    [[nodiscard]] double densest(const Entry& medium) const;  ///< its largest extinction [1/m]
    [[nodiscard]] double grid_detail(const Entry& medium) const;
    /// The least edge of a grid's voxels [m].
    [[nodiscard]] double voxel_of(int placed) const;
    [[nodiscard]] Occupied occupied_by(const Entry& box, float per_unit) const;
    [[nodiscard]] Occupied occupied_by(int placed, std::vector<OccupiedBox> boxes,
                                       float per_unit) const;
    void find_occupied();
    void find_islands();
    void find_small();

    const gl::Device& device_;
    std::vector<Grid> grids_;
    std::vector<Grid> old_grids_;  ///< old grids of the scene before, while set() runs
    std::vector<Grid> sending_;    ///< grids of a scene to come
    std::vector<PlacedGrid> placed_;
    std::vector<Entry> media_;
    std::vector<Occupied> occupied_;
    std::uint64_t occupied_id_ = 0;
    std::vector<NoiseGrid> noise_grids_;
    std::vector<NoiseGrid>
        old_noise_grids_;  ///< old noise grids of the scene before, while set() runs
    /// What small_glows() found, of what length.
    std::optional<std::pair<double, std::vector<std::optional<SmallGlow>>>> small_glows_;
    std::vector<bool> split_off_;  ///< media whose glow is that of lights
    std::optional<CarriedGlow> carried_glow_;
    MediaTraits traits_;
    float marched_light_dimming_ = 1;
    std::optional<float> peak_g_;  ///< MediaParams's, where what is scattered straight on is split
    float peak_straight_ = 0;      ///< likewise
    int uploads_ = 0;
    std::uint64_t sent_bytes_ = 0;
    double time_ = 0;
    gl::UniformBuffer<shared::MediaParams> block_;
};

}  // namespace fumarole::medium
