#include "asset/auto_scene.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cctype>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <memory>
#include <unordered_map>

#include "asset/printable.h"
#include "error.h"

namespace fumarole::asset {

namespace {

constexpr double kOpacity = 0.75;  // of the average line of sight: dense, with soft edges
constexpr double kAlbedo = 0.9;    // of smoke that reads as white
constexpr float kG = 0.3f;         // a little forward, so that it glows against the sun
constexpr double kFill = 0.8;      // of the picture, in the direction that binds
constexpr double kVfovDeg = 30;    // a portrait lens: little perspective
constexpr float kGroundAlbedo = 0.1f;
constexpr double kGroundReach = 40;  // to each side, in distances of the camera: to the horizon
constexpr double kFaint = 0.01;      // columns under this share of the mean one are haze
constexpr double kUnseen = 0.02;     // opacity, or share of sunlit smoke, that nobody sees

// From the side of the viewer's left shoulder. Rational, so that it is of unit length as written.
constexpr glm::dvec3 kSunRightFrontUp{-0.744, 0.192, 0.64};
constexpr glm::vec3 kSunIrradiance{8, 7.6f, 6.8f};      // W/m^2
constexpr glm::vec3 kWorldRadiance{0.15f, 0.2f, 0.3f};  // W/m^2/sr
// The camera stands to the right of the front and a little above: three faces are seen, the lit one
// among them.
constexpr double kAzimuthDeg = 30;
constexpr double kElevationDeg = 10;

constexpr glm::vec3 kFireColor{1, 0.3f, 0.06f};
constexpr glm::dvec3 kLuminance{0.2126, 0.7152, 0.0722};  // of linear Rec. 709
// Luminance of the brighter lines of sight through fire, over that of sunlit smoke.
constexpr double kFireOverSmoke = 3;
constexpr double kBrightShare = 0.95;  // the line of sight brighter than this share of them

/// The multiple of a power of ten nearest to `value`, as many digits kept as `scale` has three.
/// Divides where it can: 0.1 * 3 is not the nearest double to 0.3, 3 / 10.0 is.
double round_to_scale(double value, double scale, double (*rounded)(double) = std::round)
{
    const int exponent = static_cast<int>(std::floor(std::log10(scale))) - 2;
    const double power = std::pow(10.0, std::abs(exponent));
    return exponent < 0 ? rounded(value * power) / power : rounded(value / power) * power;
}

double three_digits(double value)
{
    return value == 0 ? 0 : round_to_scale(value, std::abs(value));
}

/// Three digits of each channel, as the float nearest to them, so that it is written so.
glm::vec3 three_digits(const glm::dvec3& v)
{
    return {three_digits(v.x), three_digits(v.y), three_digits(v.z)};
}

double mean_of_channels(const float* values, int channels)
{
    double sum = 0;
    for (int c = 0; c < channels; ++c)
        sum += static_cast<double>(values[c]);
    return sum / channels;
}

/// Sums of a grid's values (vec3: the mean of the channels) along one index axis, in metres times
/// value. Sparse: a brick's shadow is 8^2 columns, found by its two other coordinates.
class Columns {
public:
    Columns(const VoxelGrid& grid, int axis)
        : axis_(axis), spacing_(glm::length(glm::dvec3(grid.world_from_index[axis])))
    {
        for (std::size_t i = 0; i < grid.bricks.size(); ++i)
            add_brick(grid, i);
        for (const VoxelTile& tile : grid.tiles)
            add_tile(grid, tile);
    }

    /// Calls f(column, how many) for the columns that hold anything.
    template <class F> void for_each(F f) const
    {
        for (const auto& [key, shadow] : shadows_) {
            if (!shadow.columns) {
                f(shadow.shared, double{kShadowColumns});
                continue;
            }
            for (const double column : *shadow.columns)
                if (column + shadow.shared > 0)
                    f(column + shadow.shared, 1.0);
        }
    }

private:
    static constexpr int kDim = VoxelGrid::kBrickDim;
    static constexpr int kShadowColumns = kDim * kDim;

    struct Shadow {
        double shared = 0;  ///< what tiles add to all of its columns
        std::unique_ptr<std::array<double, kShadowColumns>> columns;  ///< null without bricks
    };

    Shadow& shadow(const glm::ivec3& brick)
    {
        const auto u = static_cast<std::uint32_t>(brick[(axis_ + 1) % 3]);
        const auto v = static_cast<std::uint32_t>(brick[(axis_ + 2) % 3]);
        return shadows_[std::uint64_t{u} << 32 | v];
    }

    void add_brick(const VoxelGrid& grid, std::size_t index)
    {
        const auto channels = static_cast<std::size_t>(grid.channels);
        const float* value = grid.values.data() + index * VoxelGrid::kBrickVoxels * channels;
        Shadow& to = shadow(grid.bricks[index]);
        if (!to.columns) {
            to.columns = std::make_unique<std::array<double, kShadowColumns>>();
            to.columns->fill(0);
        }
        // Strides that fold the axis away: the two that stay make one of 64 columns.
        const std::array<int, 3> stride{axis_ == 0 ? 0 : 1,
                                        axis_ == 1   ? 0
                                        : axis_ == 0 ? 1
                                                     : kDim,
                                        axis_ == 2 ? 0 : kDim};
        for (int z = 0; z < kDim; ++z)
            for (int y = 0; y < kDim; ++y)
                for (int x = 0; x < kDim; ++x, value += channels)
                    (*to.columns)[static_cast<std::size_t>(x * stride[0] + y * stride[1] +
                                                           z * stride[2])] +=
                        spacing_ * mean_of_channels(value, grid.channels);
    }

    void add_tile(const VoxelGrid& grid, const VoxelTile& tile)
    {
        const double value = mean_of_channels(&tile.value.x, grid.channels);
        if (value <= 0)
            return;
        const double length = spacing_ * kDim *
                              (static_cast<double>(tile.brick_max[axis_]) -
                               static_cast<double>(tile.brick_min[axis_]) + 1);
        const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        glm::ivec3 brick = tile.brick_min;
        for (brick[u] = tile.brick_min[u]; brick[u] <= tile.brick_max[u]; ++brick[u])
            for (brick[v] = tile.brick_min[v]; brick[v] <= tile.brick_max[v]; ++brick[v])
                shadow(brick).shared += value * length;
    }

    int axis_;
    double spacing_;  // metres from voxel to voxel
    std::unordered_map<std::uint64_t, Shadow> shadows_;
};

struct WeightedColumn {
    double column, count;
};

/// All columns along the three axes that meet the content, haze left out.
std::vector<WeightedColumn> content_columns(const VoxelGrid& grid)
{
    std::vector<WeightedColumn> all;
    double sum = 0, count = 0;
    for (int axis = 0; axis < 3; ++axis) {
        Columns(grid, axis).for_each([&](double column, double n) {
            all.push_back({column, n});
            sum += column * n;
            count += n;
        });
    }
    const double least = kFaint * sum / count;
    std::erase_if(all, [&](const WeightedColumn& c) { return c.column < least; });
    return all;
}

/// The column that `share` of the columns do not exceed.
double column_quantile(std::vector<WeightedColumn> columns, double share)
{
    std::sort(columns.begin(), columns.end(),
              [](const WeightedColumn& a, const WeightedColumn& b) { return a.column < b.column; });
    double count = 0, seen = 0;
    for (const WeightedColumn& c : columns)
        count += c.count;
    for (const WeightedColumn& c : columns) {
        seen += c.count;
        if (seen >= share * count)
            return c.column;
    }
    return columns.back().column;
}

struct Box {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};

    void include(const glm::dvec3& p)
    {
        min = glm::min(min, p);
        max = glm::max(max, p);
    }
};

double largest(const glm::dvec3& v)
{
    return std::max({v.x, v.y, v.z});
}

/// The corners, in the world, of a box of voxels (each spans half a spacing to every side: there
/// the field has fallen to half).
std::array<glm::dvec3, 8> world_corners(const VoxelGrid& grid, const Box& voxels)
{
    const glm::dvec3 lo = voxels.min - 0.5, hi = voxels.max + 0.5;
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] = glm::dvec3(grid.world_from_index * glm::dvec4((i & 1) != 0 ? hi.x : lo.x,
                                                                   (i & 2) != 0 ? hi.y : lo.y,
                                                                   (i & 4) != 0 ? hi.z : lo.z, 1));
    return corners;
}

template <class Points> Box bounds_of(const Points& points)
{
    Box box;
    for (const glm::dvec3& p : points)
        box.include(p);
    return box;
}

/// The box in the world that holds all of a grid.
Box world_bounds(const VoxelGrid& grid)
{
    return bounds_of(world_corners(grid, {glm::dvec3(grid.index_min), glm::dvec3(grid.index_max)}));
}

/// World points whose hull holds what is seen of a grid: in each brick and tile, the corners of the
/// box of its voxels that are not too faint to see, so that haze does not decide the framing.
/// @param per_value what a metre of a value of 1 adds to the picture, where 1 in all is a lot
std::vector<glm::dvec3> content_points(const VoxelGrid& grid, double per_value)
{
    constexpr int kDim = VoxelGrid::kBrickDim;
    // A line of sight all through the grid at this value adds kUnseen. But something is seen.
    const Box bounds = world_bounds(grid);
    const double least = std::min(kUnseen / (per_value * largest(bounds.max - bounds.min)),
                                  static_cast<double>(grid.max_value) / grid.channels);
    std::vector<glm::dvec3> points;
    const auto add_corners = [&](const Box& voxels) {
        const auto corners = world_corners(grid, voxels);
        points.insert(points.end(), corners.begin(), corners.end());
    };
    const float* value = grid.values.data();
    for (const glm::ivec3& brick : grid.bricks) {
        Box seen;
        for (int z = 0; z < kDim; ++z)
            for (int y = 0; y < kDim; ++y)
                for (int x = 0; x < kDim; ++x, value += grid.channels)
                    if (mean_of_channels(value, grid.channels) >= least)
                        seen.include(glm::dvec3(brick) * double{kDim} + glm::dvec3(x, y, z));
        if (seen.min.x <= seen.max.x)
            add_corners(seen);
    }
    for (const VoxelTile& tile : grid.tiles)
        if (mean_of_channels(&tile.value.x, grid.channels) >= least)
            add_corners({glm::dvec3(tile.brick_min) * double{kDim},
                         glm::dvec3(tile.brick_max) * double{kDim} + (kDim - 1.0)});
    return points;
}

/// Axes that a scene is built along; right-handed, front is towards the viewer.
struct Axes {
    glm::dvec3 right, front, up;

    explicit Axes(char up_axis)
        : right(1, 0, 0), front(up_axis == 'z' ? glm::dvec3(0, -1, 0) : glm::dvec3(0, 0, 1)),
          up(up_axis == 'z' ? glm::dvec3(0, 0, 1) : glm::dvec3(0, 1, 0))
    {
    }

    [[nodiscard]] glm::dvec3 world(const glm::dvec3& right_front_up) const
    {
        return right * right_front_up.x + front * right_front_up.y + up * right_front_up.z;
    }
};

/// The nearest camera in a fixed direction that keeps all points inside kFill of the picture, with
/// what binds centred. Exact: each side of the picture is a plane, and the farthest point along its
/// normal is where the plane lies.
Camera frame_points(const std::vector<glm::dvec3>& points, const Axes& axes, double aspect)
{
    const double azimuth = glm::radians(kAzimuthDeg), elevation = glm::radians(kElevationDeg);
    const glm::dvec3 to_camera =
        axes.world({std::cos(elevation) * std::sin(azimuth),
                    std::cos(elevation) * std::cos(azimuth), std::sin(elevation)});
    const glm::dvec3 view_right = glm::normalize(glm::cross(axes.up, to_camera));
    const glm::dvec3 view_up = glm::cross(to_camera, view_right);
    const Box box = bounds_of(points);
    const glm::dvec3 center = 0.5 * (box.min + box.max);

    const double slope_y = kFill * std::tan(glm::radians(kVfovDeg / 2));
    const double slope_x = slope_y * aspect;
    double right = -std::numeric_limits<double>::infinity(), left = right, top = right,
           bottom = right;
    for (const glm::dvec3& p : points) {
        const glm::dvec3 q = p - center;
        const double x = glm::dot(q, view_right), y = glm::dot(q, view_up),
                     z = glm::dot(q, to_camera);
        right = std::max(right, x + slope_x * z);
        left = std::max(left, -x + slope_x * z);
        top = std::max(top, y + slope_y * z);
        bottom = std::max(bottom, -y + slope_y * z);
    }
    const double distance =
        std::max((right + left) / (2 * slope_x), (top + bottom) / (2 * slope_y));
    const glm::dvec3 look_at =
        center + view_right * ((right - left) / 2) + view_up * ((top - bottom) / 2);

    const auto rounded = [&](const glm::dvec3& p) {
        return glm::dvec3{round_to_scale(p.x, distance), round_to_scale(p.y, distance),
                          round_to_scale(p.z, distance)};
    };
    Camera camera;
    camera.position = rounded(look_at + distance * to_camera);
    camera.look_at = rounded(look_at);
    camera.up = axes.up;
    camera.vfov_deg = kVfovDeg;
    camera.near = three_digits(0.01 * distance);
    camera.far = three_digits(1000 * distance);
    return camera;
}

BoxSurface ground_below(const Box& content, const Axes& axes, double camera_distance)
{
    const double size = largest(content.max - content.min);
    const double lowest = glm::dot(axes.up, content.min);
    const double top = round_to_scale(lowest, size, std::floor);
    const double half = three_digits(kGroundReach * camera_distance);
    BoxSurface ground;
    ground.albedo = glm::vec3(kGroundAlbedo);
    for (int axis = 0; axis < 3; ++axis) {
        if (axes.up[axis] > 0) {
            ground.min[axis] = top - three_digits(size);
            ground.max[axis] = top;
        } else {
            const double middle = round_to_scale((content.min[axis] + content.max[axis]) / 2, half);
            ground.min[axis] = middle - half;
            ground.max[axis] = middle + half;
        }
    }
    return ground;
}

std::string lower_case(std::string text)
{
    std::transform(text.begin(), text.end(), text.begin(),
                   [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
    return text;
}

}  // namespace

double sigma_t_for_opacity(const VoxelGrid& grid, double opacity)
{
    assert(!grid.empty() && opacity > 0 && opacity < 1);
    const std::vector<WeightedColumn> columns = content_columns(grid);
    double sum = 0, count = 0, least = columns.front().column;
    for (const WeightedColumn& c : columns) {
        sum += c.column * c.count;
        count += c.count;
        least = std::min(least, c.column);
    }
    const auto mean_opacity = [&](double sigma_t) {
        double opaque = 0;
        for (const WeightedColumn& c : columns)
            opaque -= c.count * std::expm1(-sigma_t * c.column);
        return opaque / count;
    };

    // Since 1 - exp(-x) <= x, less than this is never enough; and what is enough for the least
    // column is enough for all.
    double low = std::log(opacity * count / sum);
    double high = std::log(-std::log1p(-opacity) / least);
    for (int i = 0; i < 60 && high - low > 1e-12; ++i) {
        const double middle = (low + high) / 2;
        (mean_opacity(std::exp(middle)) < opacity ? low : high) = middle;
    }
    return std::exp((low + high) / 2);
}

std::string guess_emission_grid(const VdbInfo& file, const std::string& density)
{
    const auto find = [&](const std::string& name) -> const GridInfo* {
        for (const GridInfo& grid : file.grids) {
            const std::string base = lower_case(grid.name.substr(0, grid.name.find('[')));
            if (base == name && grid.name != density && grid.refusal.empty() &&
                grid.active_voxels > 0 && grid.max > 0)
                return &grid;
        }
        return nullptr;
    };
    for (const char* name : {"flame", "flames", "fire", "burn", "burning", "emission"})
        if (const GridInfo* grid = find(name))
            return grid->name;

    // Hot is not burning: a solver's temperature fills all of its smoke. Where it is a part of it,
    // it marks the source.
    const auto smoke = std::find_if(file.grids.begin(), file.grids.end(),
                                    [&](const GridInfo& grid) { return grid.name == density; });
    for (const char* name : {"heat", "temperature", "temp"}) {
        const GridInfo* grid = find(name);
        if (grid != nullptr && smoke != file.grids.end() &&
            static_cast<double>(grid->active_voxels) <
                0.6 * static_cast<double>(smoke->active_voxels))
            return grid->name;
    }
    return "";
}

UpGuess guess_up(const std::string& creator, const glm::dvec3& size)
{
    const std::string who = lower_case(creator);
    const std::string by = "written by " + printable(creator);
    if (who.find("blender") != std::string::npos || who.find("mantaflow") != std::string::npos)
        return {'z', by};
    if (who.find("houdini") != std::string::npos)
        return {'y', by};
    const auto ratio = [](double a, double b) { return std::max(a, b) / std::min(a, b); };
    const auto alike = [&](double a, double b) { return ratio(a, b) < 1.15; };
    const auto unlike = [&](double a, double b) { return ratio(a, b) > 1.25; };
    // A plume, a cloud or a fire is about as deep as it is wide.
    if (alike(size.x, size.y) && unlike(size.x, size.z))
        return {'z', "as deep in y as wide in x"};
    if (alike(size.x, size.z) && unlike(size.x, size.y))
        return {'y', "as deep in z as wide in x"};
    if (size.z > 1.25 * std::max(size.x, size.y))
        return {'z', "tallest in z"};
    if (size.y > 1.25 * std::max(size.x, size.z))
        return {'y', "tallest in y"};
    return {'y', "as film tools have it, for its shape does not tell"};
}

LoadedScene frame_grids(std::shared_ptr<const VoxelGrid> density,
                        std::shared_ptr<const VoxelGrid> emission, char up, glm::uvec2 resolution)
{
    assert(density && !density->empty() && (up == 'y' || up == 'z'));
    LoadedScene loaded;
    std::vector<std::string>& notes = loaded.notes;

    GridMedium medium;
    medium.grid = density->name;
    medium.g = kG;
    const double sigma_t = sigma_t_for_opacity(*density, kOpacity);
    medium.sigma_s_per_density = three_digits(glm::dvec3(kAlbedo * sigma_t));
    medium.sigma_a_per_density = three_digits(glm::dvec3((1 - kAlbedo) * sigma_t));
    std::vector<glm::dvec3> points = content_points(*density, sigma_t);
    notes.push_back(
        fmt::format("coefficient {:.3g} /m per density: average line of sight {:.0f} % opaque",
                    sigma_t, 100 * kOpacity));

    if (emission && !emission->empty()) {
        // The colour is the grid's own where it has three channels.
        const glm::dvec3 color = emission->channels == 3 ? glm::dvec3(1) : glm::dvec3(kFireColor);
        // What is opaque and lit from the side gives about irradiance / 4 pi.
        const double sunlit_smoke =
            glm::dot(glm::dvec3(kSunIrradiance), kLuminance) / (4 * glm::pi<double>());
        const double bright = column_quantile(content_columns(*emission), kBrightShare);
        const double luminance_per_unit = kFireOverSmoke * sunlit_smoke / bright;
        medium.emission_grid = emission->name;
        medium.emission_per_unit =
            three_digits(color * (luminance_per_unit / glm::dot(color, kLuminance)));
        const auto seen = content_points(*emission, luminance_per_unit / sunlit_smoke);
        points.insert(points.end(), seen.begin(), seen.end());
        notes.push_back(
            fmt::format("grid '{}' glows: {:.3g} W/m^2/sr per metre per unit in red: a bright line "
                        "of sight through it is {:.2g} times as bright as sunlit smoke",
                        emission->name, medium.emission_per_unit.r, kFireOverSmoke));
    }
    medium.density = std::move(density);
    medium.emission = std::move(emission);

    const Axes axes(up);
    const Box content = bounds_of(points);
    const glm::dvec3 size = content.max - content.min;
    Scene& scene = loaded.scene;
    scene.resolution = resolution;
    scene.camera = frame_points(
        points, axes, static_cast<double>(resolution.x) / static_cast<double>(resolution.y));
    scene.world.radiance = kWorldRadiance;
    scene.lights.emplace_back(SunLight{axes.world(kSunRightFrontUp), kSunIrradiance});
    const double distance = glm::distance(scene.camera.position, scene.camera.look_at);
    scene.surfaces.emplace_back(ground_below(content, axes, distance));
    scene.media.emplace_back(std::move(medium));
    notes.push_back(fmt::format("framed {:.3g} x {:.3g} x {:.3g} m of content from {:.3g} m",
                                size.x, size.y, size.z, distance));
    return loaded;
}

LoadedScene make_auto_scene(const std::filesystem::path& vdb, const AutoSceneOptions& options)
{
    LoadedGrid density = load_grid(vdb, options.grid);
    if (density.grid.empty())
        throw Error(fmt::format("{}: grid '{}' is 0 everywhere: nothing to show; name another grid",
                                vdb.string(), density.grid.name));
    const VdbInfo info = inspect_vdb(vdb);

    std::vector<std::string> notes = std::move(density.notes);
    std::shared_ptr<const VoxelGrid> emission;
    if (const std::string name = guess_emission_grid(info, density.grid.name); !name.empty()) {
        LoadedGrid loaded = load_grid(vdb, name);
        notes.insert(notes.end(), loaded.notes.begin(), loaded.notes.end());
        emission = std::make_shared<const VoxelGrid>(std::move(loaded.grid));
    }
    const auto grid = std::make_shared<const VoxelGrid>(std::move(density.grid));
    char up = options.up;
    if (up == 0) {
        const Box content = world_bounds(*grid);
        const UpGuess guess = guess_up(info.creator, content.max - content.min);
        up = guess.axis;
        notes.push_back(fmt::format("{} is up ({})", up, guess.why));
    }

    LoadedScene loaded = frame_grids(grid, emission, up, options.resolution);
    auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    medium.file = vdb.string();
    notes.insert(notes.end(), loaded.notes.begin(), loaded.notes.end());
    loaded.notes = std::move(notes);
    return loaded;
}

}  // namespace fumarole::asset
