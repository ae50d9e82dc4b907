#pragma once

#include <filesystem>
#include <functional>
#include <glm/glm.hpp>
#include <memory>
#include <vector>

#include "study/reference_geometry.h"
#include "study/stability.h"

// What the stability cases share: plain scenes, truths in double precision, pictures drawn and
// measured.

namespace fumarole::study {

/// Settings whose values are asked for by hand: StabilityCase::asks.
inline constexpr std::string_view kTargetFormat = "target-format", kTransparency = "transparency";

// Bounds that several cases have, with their reasons.
inline constexpr double kScreenStep = 1.0 / 255;
inline constexpr std::string_view kScreenReason =
    "1/255: less than a step of an 8-bit screen under white";
inline constexpr double kJustNoticed = 0.01;
inline constexpr std::string_view kNoticeReason =
    "1 % of the mean: about the least contrast that an eye sees between two flat fields";
inline constexpr double kHalfFloat = 0x1p-11;
inline constexpr std::string_view kHalfReason =
    "2^-11: what storing a value under 1 in 16-bit floats costs at most";

/// A camera ray that knows its slant.
struct PixelRay : Ray {
    double length_per_z = 1;  ///< metres of ray per metre of view depth
};

/// The ray through a point of the scene's picture, in pixels from the top left.
PixelRay pixel_ray(const Scene& scene, glm::dvec2 at);

/// Something that varies over a picture.
using PictureField = std::function<glm::dvec3(const PixelRay& ray)>;

/// RGB, rows from the top.
struct Picture {
    int width = 0, height = 0;
    std::vector<float> rgb;

    [[nodiscard]] double mean() const;
    [[nodiscard]] glm::vec3 at(int x, int y) const;
};

/// The field at each pixel's centre.
Picture evaluate(const Scene& scene, const PictureField& field);

/// A layer of a Still or of a ReferenceStill.
template <class AnyStill> Picture layer(const AnyStill& still, std::vector<float> AnyStill::*which)
{
    return {still.width, still.height, still.*which};
}

/// Largest |actual - expected|.
StabilityFigure worst_difference(const Picture& actual, const Picture& expected);
/// Largest |actual - expected| / |expected|, of values that are not 0.
StabilityFigure worst_ratio(const Picture& actual, const Picture& expected);
/// Root of the mean square of actual - expected, over the mean of |expected|.
StabilityFigure rms_over_mean(const Picture& actual, const Picture& expected);
/// |mean(actual) / mean(expected) - 1|.
StabilityFigure mean_ratio(const Picture& actual, const Picture& expected);
/// Values of any layer that are not finite, or negative, or a transmittance above 1.
StabilityFigure count_bad(const Still& still);
/// The worse of two; NaN is the worst.
StabilityFigure worse(StabilityFigure a, StabilityFigure b);

/// Least-squares slope of -log(error) over log(steps).
double fitted_order(const std::vector<int>& steps, const std::vector<double>& errors);

/// A black world with nothing in it; the eye at the origin looks along -y, 40 degrees high, z up.
Scene bare_scene(int size);

/// A box that is wider than the view, `near_y` to `far_y` metres ahead of bare_scene's eye.
BoxMedium slab(double near_y, double far_y);

/// Metres of a ray inside a box from the eye's near plane on.
double length_in(const Scene& scene, const PixelRay& ray, const BoxMedium& box);

/// exp(-optical depth) of a homogeneous box.
glm::dvec3 box_transmittance(const Scene& scene, const PixelRay& ray, const BoxMedium& box);

/// exp(-optical depth) of all media from the near plane on, on the CPU in double precision.
Picture true_transmittance(const Scene& scene);

/// Radiance of a sun scattered once in a slab() that shades itself.
glm::dvec3 sun_in_slab(const Scene& scene, const PixelRay& ray, const BoxMedium& box,
                       const SunLight& sun);

/// A scalar grid of `bricks` bricks along each axis from brick `first` on, filled by index.
std::shared_ptr<VoxelGrid> make_grid(glm::ivec3 bricks, const glm::dmat4& world_from_index,
                                     const std::function<double(glm::ivec3)>& value,
                                     glm::ivec3 first = glm::ivec3(0));

/// voxels of `size` metres, index 0 at `at`.
glm::dmat4 voxels(double size, glm::dvec3 at);

/// A lump of smoke without symmetry, 3 m across, 5 m ahead of bare_scene's eye.
GridMedium lump(double sigma_s, double sigma_a);

/// Smoke, height fog and three kinds of light, in `unit`s of that many metres, at `origin`: the
/// same picture for all of them.
Scene full_scene(double unit, glm::dvec3 origin, bool surfaces);

/// Where a subject is put to the test.
class StabilityBench {
public:
    StabilityBench(SceneRenderer& renderer, Settings subject, std::filesystem::path scratch)
        : settings{subject}, renderer_{renderer}, scratch_{std::move(scratch)}
    {
    }

    const Settings settings;  ///< settings of the subject, unchanged

    /// The settings with something of them changed, as the command line names it.
    [[nodiscard]] Settings with(std::string_view name, std::string_view value) const;
    /// A ray or a column of froxels for each pixel.
    [[nodiscard]] Settings full_size() const;
    /// At full size in 32-bit floats, sampled at middles, in so many steps or slices: what is left
    /// is the march.
    [[nodiscard]] Settings march_alone(int steps) const;
    [[nodiscard]] Settings march_alone() const { return march_alone(settings.steps); }
    /// What makes a layer smaller than the picture: 1/2 and 1/4 of it, or froxels as they are.
    [[nodiscard]] std::vector<Settings> small_layers() const;

    /// One frame on its own; another `frame` has other jitter.
    [[nodiscard]] Still render(const Scene& scene, const Settings& with, std::uint32_t frame) const;
    [[nodiscard]] Still render(const Scene& scene) const { return render(scene, settings, 0); }

    /// What so many frames of a still view gather, with nothing before them.
    [[nodiscard]] Picture gathered(const Scene& scene, const Settings& with, int frames) const;

    /// The media over a white picture whose depths are given: view_z [m] by pixel from the top
    /// left; 0 for the sky.
    [[nodiscard]] Picture over_white(const Scene& scene, const Settings& with,
                                     const std::function<double(int x, int y)>& view_z) const;

    /// For a file that the case writes and removes.
    [[nodiscard]] const std::filesystem::path& scratch() const { return scratch_; }

    [[nodiscard]] Renderer& renderer() const { return renderer_.renderer(); }

private:
    SceneRenderer& renderer_;
    std::filesystem::path scratch_;
};

/// A view that a host draws frame by frame, from which froxels keep their history.
class StabilityView {
public:
    StabilityView(const StabilityBench& bench, Settings settings);

    /// What a history has to outlive: another light, another medium.
    void set_scene(const Scene& scene);
    /// The next frame of it: surfaces, and the media over them.
    Picture draw(const Camera& camera, glm::uvec2 size);
    /// The same of a scene whose view alone may have changed.
    Picture draw(const Scene& scene) { return draw(scene.camera, scene.resolution); }

private:
    Renderer& renderer_;
    View view_;
    Settings settings_;
    std::uint64_t frames_ = 0;
};

/// Each adds the cases of its groups.
void add_extinction_cases(std::vector<StabilityCase>& table);   ///< 1
void add_light_cases(std::vector<StabilityCase>& table);        ///< 2, 3
void add_depth_cases(std::vector<StabilityCase>& table);        ///< 4, 5
void add_march_cases(std::vector<StabilityCase>& table);        ///< 6
void add_motion_cases(std::vector<StabilityCase>& table);       ///< 7
void add_storage_cases(std::vector<StabilityCase>& table);      ///< 8
void add_frame_cases(std::vector<StabilityCase>& table);        ///< 9
void add_invariance_cases(std::vector<StabilityCase>& table);   ///< 10, 11
void add_hostile_cases(std::vector<StabilityCase>& table);      ///< 12
void add_field_cases(std::vector<StabilityCase>& table);        ///< 1, 3 and 7, all bounces
void add_transparent_cases(std::vector<StabilityCase>& table);  ///< 4, 7
void add_indoor_cases(std::vector<StabilityCase>& table);       ///< 4
void add_probe_cases(std::vector<StabilityCase>& table);        ///< 3

}  // namespace fumarole::study
