#include <fumarole/asset/auto_scene.h>

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
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace {

constexpr double kOpacity = 0.75;       // of the average line of sight: dense, with soft edges
constexpr double kAlbedo = 0.9;         // of smoke that reads as white
constexpr float kG = 0.3f;              // a little forward, so that it glows against the sun
constexpr double kFill = 0.8;           // of the picture, in the direction that binds
constexpr double kVfovDeg = 30;         // a portrait lens: little perspective
constexpr float kGroundAlbedo = 0.06f;  // dark, so that pale smoke stands out
constexpr double kGroundReach = 40;     // to each side, in distances of the camera: to the horizon
constexpr double kFaint = 0.01;         // columns under this share of the mean one are haze
constexpr double kUnseen = 0.02;        // opacity, or share of sunlit smoke, that nobody sees

// From the side of the viewer's left shoulder. Rational, so that it is of unit length as written.
constexpr glm::dvec3 kSunRightFrontUp{-0.744, 0.192, 0.64};
constexpr glm::vec3 kSunIrradiance{8, 7.6f, 6.8f};  // W/m^2
// W/m^2/sr. A hundredth of the sun: more would drown the sun's shading, which is the form of the
// smoke.
constexpr glm::vec3 kWorldRadiance{0.05f, 0.07f, 0.11f};
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
        // Strides that fold one axis away: the two that stay make one of 64 columns.
        static constexpr std::array<std::array<int, 3>, 3> kStrides{
            {{0, 1, kDim}, {1, 0, kDim}, {1, kDim, 0}}};
        const auto& stride = kStrides[static_cast<std::size_t>(axis_)];
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
    glm::dvec3 min, max;

    [[nodiscard]] glm::dvec3 center() const { return 0.5 * (min + max); }
    [[nodiscard]] glm::dvec3 size() const { return max - min; }
};

double largest(const glm::dvec3& v)
{
    return std::max({v.x, v.y, v.z});
}

/// Linear functions of world space, and the largest value of each over boxes of voxels: what it
/// takes to put planes around a content of any transform, exactly, without keeping its points.
class Reach {
public:
    /// Measures dot(direction, p - origin), for directions of any length.
    Reach(const glm::dvec3& origin, std::vector<glm::dvec3> directions)
        : origin_(origin), directions_(std::move(directions)),
          farthest_(directions_.size(), -std::numeric_limits<double>::infinity())
    {
    }

    [[nodiscard]] double operator[](std::size_t direction) const { return farthest_[direction]; }

    /// Takes in the voxels of `grid` that are at least `least`.
    void include(const VoxelGrid& grid, double least)
    {
        std::vector<Function> functions;
        for (const glm::dvec3& direction : directions_)
            functions.emplace_back(grid, direction, origin_);
        constexpr int kDim = VoxelGrid::kBrickDim;
        const float* brick_values = grid.values.data();
        for (const glm::ivec3& brick : grid.bricks) {
            const float* value = brick_values;
            brick_values += VoxelGrid::kBrickVoxels * grid.channels;
            const glm::dvec3 first = glm::dvec3(brick) * double{kDim};
            if (!reaches_farther(functions, {first, first + (kDim - 1.0)}))
                continue;
            for (int z = 0; z < kDim; ++z) {
                for (int y = 0; y < kDim; ++y) {
                    int begin = kDim, end = -1;
                    for (int x = 0; x < kDim; ++x, value += grid.channels) {
                        if (mean_of_channels(value, grid.channels) >= least) {
                            begin = std::min(begin, x);
                            end = x;
                        }
                    }
                    if (begin <= end)
                        include(functions,
                                {first + glm::dvec3(begin, y, z), first + glm::dvec3(end, y, z)});
                }
            }
        }
        for (const VoxelTile& tile : grid.tiles)
            if (mean_of_channels(&tile.value.x, grid.channels) >= least)
                include(functions, {glm::dvec3(tile.brick_min) * double{kDim},
                                    glm::dvec3(tile.brick_max) * double{kDim} + (kDim - 1.0)});
    }

    /// Takes in a box of voxels.
    void include(const VoxelGrid& grid, const Box& voxels)
    {
        std::vector<Function> functions;
        for (const glm::dvec3& direction : directions_)
            functions.emplace_back(grid, direction, origin_);
        include(functions, voxels);
    }

private:
    /// One of the functions in index space.
    struct Function {
        glm::dvec3 gradient;
        double constant;

        Function(const VoxelGrid& grid, const glm::dvec3& direction, const glm::dvec3& origin)
            : gradient(glm::transpose(glm::dmat3(grid.world_from_index)) * direction),
              constant(glm::dot(direction, glm::dvec3(grid.world_from_index[3]) - origin))
        {
            // A voxel spans half a spacing to every side: there the field has fallen to half.
            const glm::dvec3 half_voxel = 0.5 * glm::abs(gradient);
            constant += half_voxel.x + half_voxel.y + half_voxel.z;
        }

        [[nodiscard]] double largest_in(const Box& voxels) const
        {
            double sum = constant;
            for (int axis = 0; axis < 3; ++axis)
                sum += gradient[axis] * (gradient[axis] > 0 ? voxels.max[axis] : voxels.min[axis]);
            return sum;
        }
    };

    [[nodiscard]] bool reaches_farther(const std::vector<Function>& functions,
                                       const Box& voxels) const
    {
        for (std::size_t i = 0; i < functions.size(); ++i)
            if (functions[i].largest_in(voxels) > farthest_[i])
                return true;
        return false;
    }

    void include(const std::vector<Function>& functions, const Box& voxels)
    {
        for (std::size_t i = 0; i < functions.size(); ++i)
            farthest_[i] = std::max(farthest_[i], functions[i].largest_in(voxels));
    }

    glm::dvec3 origin_;
    std::vector<glm::dvec3> directions_;
    std::vector<double> farthest_;
};

/// The box in the world that holds all of a grid.
Box world_bounds(const VoxelGrid& grid)
{
    const glm::dvec3 origin(grid.world_from_index * glm::dvec4(glm::dvec3(grid.index_min), 1));
    Reach reach(origin, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
    reach.include(grid, Box{glm::dvec3(grid.index_min), glm::dvec3(grid.index_max)});
    return {origin - glm::dvec3(reach[3], reach[4], reach[5]),
            origin + glm::dvec3(reach[0], reach[1], reach[2])};
}

/// A grid and the least of its values that is seen.
struct Content {
    const VoxelGrid* grid;
    double least;

    /// @param per_value what a metre of a value of 1 adds to the picture, where 1 in all is a lot
    Content(const VoxelGrid& of, double per_value)
        : grid(&of),
          // A line of sight all through the grid at this value adds kUnseen. But something is seen.
          least(std::min(kUnseen / (per_value * largest(world_bounds(of).size())),
                         static_cast<double>(of.max_value) / of.channels))
    {
    }
};

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

struct Framing {
    Camera camera;
    Box content;  ///< bounds of what is seen, metres
};

/// The nearest camera in a fixed direction that keeps all content inside kFill of the picture,
/// centred. Exact: each side of that inner picture is a plane through the camera, and where it lies
/// follows from how far the content reaches along the plane's normal.
Framing frame(const std::vector<Content>& contents, const Axes& axes, double aspect)
{
    const double azimuth = glm::radians(kAzimuthDeg), elevation = glm::radians(kElevationDeg);
    const glm::dvec3 to_camera =
        axes.world({std::cos(elevation) * std::sin(azimuth),
                    std::cos(elevation) * std::cos(azimuth), std::sin(elevation)});
    const glm::dvec3 right = glm::normalize(glm::cross(axes.up, to_camera));
    const glm::dvec3 up = glm::cross(to_camera, right);
    const double slope_y = kFill * std::tan(glm::radians(kVfovDeg / 2));
    const double slope_x = slope_y * aspect;

    const glm::dvec3 center = world_bounds(*contents.front().grid).center();
    Reach reach(center, {right + slope_x * to_camera,
                         -right + slope_x * to_camera,
                         up + slope_y * to_camera,
                         -up + slope_y * to_camera,
                         {1, 0, 0},
                         {0, 1, 0},
                         {0, 0, 1},
                         {-1, 0, 0},
                         {0, -1, 0},
                         {0, 0, -1}});
    for (const Content& content : contents)
        reach.include(*content.grid, content.least);

    const double distance =
        std::max((reach[0] + reach[1]) / (2 * slope_x), (reach[2] + reach[3]) / (2 * slope_y));
    const glm::dvec3 look_at =
        center + right * ((reach[0] - reach[1]) / 2) + up * ((reach[2] - reach[3]) / 2);

    const auto rounded = [&](const glm::dvec3& p) {
        return glm::dvec3{round_to_scale(p.x, distance), round_to_scale(p.y, distance),
                          round_to_scale(p.z, distance)};
    };
    Framing framing;
    framing.content = {center - glm::dvec3(reach[7], reach[8], reach[9]),
                       center + glm::dvec3(reach[4], reach[5], reach[6])};
    Camera& camera = framing.camera;
    camera.position = rounded(look_at + distance * to_camera);
    camera.look_at = rounded(look_at);
    camera.up = axes.up;
    camera.vfov_deg = kVfovDeg;
    camera.near = three_digits(0.01 * distance);
    camera.far = three_digits(1000 * distance);
    return framing;
}

BoxSurface ground_below(const Box& content, const Axes& axes, double camera_distance)
{
    const double size = largest(content.size());
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
            const double middle = round_to_scale(content.center()[axis], half);
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
    std::vector<Content> contents{{*density, sigma_t}};
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
        contents.emplace_back(*emission, luminance_per_unit / sunlit_smoke);
        notes.push_back(
            fmt::format("grid '{}' glows: {:.3g} W/m^2/sr per metre per unit in red: a bright line "
                        "of sight through it is {:.2g} times as bright as sunlit smoke",
                        emission->name, medium.emission_per_unit.r, kFireOverSmoke));
    }
    medium.density = std::move(density);
    medium.emission = std::move(emission);

    const Axes axes(up);
    const Framing framing = frame(
        contents, axes, static_cast<double>(resolution.x) / static_cast<double>(resolution.y));
    const double distance = glm::distance(framing.camera.position, framing.camera.look_at);
    const glm::dvec3 size = framing.content.size();
    notes.push_back(fmt::format("framed {:.3g} x {:.3g} x {:.3g} m of content from {:.3g} m",
                                size.x, size.y, size.z, distance));

    Scene& scene = loaded.scene;
    scene.resolution = resolution;
    scene.camera = framing.camera;
    scene.world.radiance = kWorldRadiance;
    scene.lights.emplace_back(SunLight{axes.world(kSunRightFrontUp), kSunIrradiance});
    scene.surfaces.emplace_back(ground_below(framing.content, axes, distance));
    scene.media.emplace_back(std::move(medium));
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
        const UpGuess guess = guess_up(info.creator, world_bounds(*grid).size());
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
