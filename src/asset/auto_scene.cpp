#include <fumarole/asset/auto_scene.h>

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <fmt/format.h>
#include <functional>
#include <glm/gtc/constants.hpp>
#include <limits>
#include <memory>
#include <unordered_map>

#include "asset/grid_names.h"
#include "asset/medium_fit.h"
#include "asset/printable.h"
#include "asset/scene_ranges.h"
#include "blackbody.h"
#include <fumarole/asset/animation.h>
#include <fumarole/asset/sequence.h>
#include <fumarole/errors.h>

namespace fumarole::asset {

namespace fs = std::filesystem;

namespace {

constexpr double kOpacity = 0.75;       // of the average line of sight: dense, with soft edges
constexpr double kFireOpacity = 0.25;   // of fire without smoke, which hides little
constexpr double kAlbedo = 0.9;         // of smoke that reads as white
constexpr float kG = 0.3f;              // a little forward, so that it glows against the sun
constexpr double kFill = 0.8;           // of the picture, in the direction that binds
constexpr double kVfovDeg = 30;         // a portrait lens: little perspective
constexpr float kGroundAlbedo = 0.06f;  // dark, so that pale smoke stands out
// Of the ground to each side, in distances of the camera: past the far plane, which cuts it in a
// straight line a pixel or two under the horizon. An end in sight would show a corner and a side.
constexpr double kGroundReach = 2000;
constexpr double kFar = 1000;     // of the far plane, in distances of the camera
constexpr double kFaint = 0.01;   // columns under this share of the mean one are haze
constexpr double kUnseen = 0.02;  // opacity, or share of sunlit smoke, that nobody sees

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
        if (few_and_large(grid.tiles)) {
            add_areas(grid);
            return;
        }
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
        for (const Area& area : areas_)
            if (area.column > 0 && area.count > 0)
                f(area.column, area.count);
    }

private:
    static constexpr int kDim = VoxelGrid::kBrickDim;
    static constexpr int kShadowColumns = kDim * kDim;

    struct Shadow {
        double shared = 0;  ///< what tiles add to all of its columns
        std::unique_ptr<std::array<double, kShadowColumns>> columns;  ///< null without bricks
    };

    /// Equal columns of tiles that are together, without those of bricks.
    struct Area {
        double column = 0, count = 0;
    };

    /// Whether tiles have so many columns, and are so few, that areas of equal ones are counted.
    [[nodiscard]] bool few_and_large(const std::vector<VoxelTile>& tiles) const
    {
        constexpr std::size_t kFew = 256;
        constexpr double kMany = 1 << 18;  // bricks of shadow
        double all = 0;
        for (const VoxelTile& tile : tiles) {
            const glm::dvec3 size = glm::dvec3(tile.brick_max - tile.brick_min) + 1.0;
            all += size[(axis_ + 1) % 3] * size[(axis_ + 2) % 3];
        }
        return tiles.size() <= kFew && all > kMany;
    }

    /// The tiles' shadows, cut where any of them begins or ends.
    void add_areas(const VoxelGrid& grid)
    {
        const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        std::vector<int> cuts_u, cuts_v;
        for (const VoxelTile& tile : grid.tiles) {
            cuts_u.insert(cuts_u.end(), {tile.brick_min[u], tile.brick_max[u] + 1});
            cuts_v.insert(cuts_v.end(), {tile.brick_min[v], tile.brick_max[v] + 1});
        }
        for (std::vector<int>* cuts : {&cuts_u, &cuts_v}) {
            std::sort(cuts->begin(), cuts->end());
            cuts->erase(std::unique(cuts->begin(), cuts->end()), cuts->end());
        }
        const auto cell = [](const std::vector<int>& cuts, int at) {
            return std::upper_bound(cuts.begin(), cuts.end(), at) - cuts.begin() - 1;
        };
        const auto width = static_cast<std::ptrdiff_t>(cuts_u.size()) - 1;
        const auto height = static_cast<std::ptrdiff_t>(cuts_v.size()) - 1;
        const auto area = [&](std::ptrdiff_t i, std::ptrdiff_t j) -> Area& {
            return areas_[static_cast<std::size_t>(j * width + i)];
        };
        areas_.resize(static_cast<std::size_t>(width * height));
        for (std::ptrdiff_t j = 0; j < height; ++j)
            for (std::ptrdiff_t i = 0; i < width; ++i) {
                const auto edge = [](const std::vector<int>& cuts, std::ptrdiff_t k) {
                    const auto at = static_cast<std::size_t>(k);
                    return static_cast<double>(cuts[at + 1]) - static_cast<double>(cuts[at]);
                };
                area(i, j).count = kShadowColumns * edge(cuts_u, i) * edge(cuts_v, j);
            }
        for (const VoxelTile& tile : grid.tiles) {
            const double value = mean_of_channels(&tile.value.x, grid.channels);
            for (auto j = cell(cuts_v, tile.brick_min[v]); j <= cell(cuts_v, tile.brick_max[v]);
                 ++j)
                for (auto i = cell(cuts_u, tile.brick_min[u]); i <= cell(cuts_u, tile.brick_max[u]);
                     ++i)
                    area(i, j).column += value * length(tile);
        }
        for (auto& [key, shadow] : shadows_) {
            const auto i = cell(cuts_u, static_cast<int>(static_cast<std::uint32_t>(key >> 32)));
            const auto j = cell(cuts_v, static_cast<int>(static_cast<std::uint32_t>(key)));
            if (i < 0 || j < 0 || i >= width || j >= height)
                continue;
            shadow.shared = area(i, j).column;
            area(i, j).count -= kShadowColumns;
        }
    }

    /// Of a tile along the axis. [m]
    [[nodiscard]] double length(const VoxelTile& tile) const
    {
        return spacing_ * kDim *
               (static_cast<double>(tile.brick_max[axis_]) -
                static_cast<double>(tile.brick_min[axis_]) + 1);
    }

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
                for (int x = 0; x < kDim; ++x, value += channels) {
                    const int column = x * stride[0] + y * stride[1] + z * stride[2];
                    (*to.columns)[static_cast<std::size_t>(column)] +=
                        spacing_ * mean_of_channels(value, grid.channels);
                }
    }

    void add_tile(const VoxelGrid& grid, const VoxelTile& tile)
    {
        const double value = mean_of_channels(&tile.value.x, grid.channels);
        if (value <= 0)
            return;
        const int u = (axis_ + 1) % 3, v = (axis_ + 2) % 3;
        glm::ivec3 brick = tile.brick_min;
        for (brick[u] = tile.brick_min[u]; brick[u] <= tile.brick_max[u]; ++brick[u])
            for (brick[v] = tile.brick_min[v]; brick[v] <= tile.brick_max[v]; ++brick[v])
                shadow(brick).shared += value * length(tile);
    }

    int axis_;
    double spacing_;  // metres from voxel to voxel
    std::unordered_map<std::uint64_t, Shadow> shadows_;
    std::vector<Area> areas_;
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
        const std::vector<Function> functions = functions_of(grid.world_from_index);
        constexpr int kDim = VoxelGrid::kBrickDim;
        const float* brick_values = grid.values.data();
        for (const glm::ivec3& brick : grid.bricks) {
            const float* value = brick_values;
            brick_values += std::ptrdiff_t{VoxelGrid::kBrickVoxels} * grid.channels;
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
    void include(const glm::dmat4& world_from_index, const Box& voxels)
    {
        include(functions_of(world_from_index), voxels);
    }

    /// How much farther a box of voxels reaches than all that was taken in; <= 0: nowhere.
    [[nodiscard]] double excess(const glm::dmat4& world_from_index, const Box& voxels) const
    {
        double most = -std::numeric_limits<double>::infinity();
        const std::vector<Function> functions = functions_of(world_from_index);
        for (std::size_t i = 0; i < functions.size(); ++i)
            most = std::max(most, functions[i].largest_in(voxels) - farthest_[i]);
        return most;
    }

private:
    /// One of the functions in index space.
    struct Function {
        glm::dvec3 gradient;
        double constant;

        Function(const glm::dmat4& world_from_index, const glm::dvec3& direction,
                 const glm::dvec3& origin)
            : gradient(glm::transpose(glm::dmat3(world_from_index)) * direction),
              constant(glm::dot(direction, glm::dvec3(world_from_index[3]) - origin))
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

    [[nodiscard]] std::vector<Function> functions_of(const glm::dmat4& world_from_index) const
    {
        std::vector<Function> functions;
        for (const glm::dvec3& direction : directions_)
            functions.emplace_back(world_from_index, direction, origin_);
        return functions;
    }

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

Box index_bounds(const VoxelGrid& grid)
{
    return {glm::dvec3(grid.index_min), glm::dvec3(grid.index_max)};
}

/// The box in the world that holds all of a grid.
Box world_bounds(const VoxelGrid& grid)
{
    const glm::dvec3 origin(grid.world_from_index * glm::dvec4(glm::dvec3(grid.index_min), 1));
    Reach reach(origin, {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}, {-1, 0, 0}, {0, -1, 0}, {0, 0, -1}});
    reach.include(grid.world_from_index, index_bounds(grid));
    return {origin - glm::dvec3(reach[3], reach[4], reach[5]),
            origin + glm::dvec3(reach[0], reach[1], reach[2])};
}

/// What is shown of a file. Each may be null or empty.
struct Shown {
    /// The emission of a temperature is the luminance that it has as a blackbody.
    std::shared_ptr<const VoxelGrid> density, emission;
    std::shared_ptr<const VoxelGrid> temperature;
};

/// The luminance of a blackbody of each temperature of a grid. [W/m^2/sr per metre]
std::shared_ptr<const VoxelGrid> blackbody_grid(const VoxelGrid& temperature, double kelvin)
{
    VoxelGrid glow = temperature;
    glow.bricks.clear();
    glow.values.clear();
    glow.tiles.clear();
    glow.max_value = 0;
    glow.index_min = glm::ivec3(std::numeric_limits<int>::max());
    glow.index_max = glm::ivec3(std::numeric_limits<int>::min());
    const auto luminance = [&](float value) {
        return static_cast<float>(blackbody_luminance(kelvin * static_cast<double>(value)));
    };
    const auto add = [&](const glm::ivec3& first, const glm::ivec3& last, float value) {
        glow.max_value = std::max(glow.max_value, value);
        glow.index_min = glm::min(glow.index_min, first * VoxelGrid::kBrickDim);
        glow.index_max = glm::max(glow.index_max, (last + 1) * VoxelGrid::kBrickDim - 1);
    };
    for (std::size_t b = 0; b < temperature.bricks.size(); ++b) {
        const auto begin =
            temperature.values.begin() + static_cast<std::ptrdiff_t>(b * VoxelGrid::kBrickVoxels);
        const float most = luminance(*std::max_element(begin, begin + VoxelGrid::kBrickVoxels));
        if (most == 0)
            continue;
        add(temperature.bricks[b], temperature.bricks[b], most);
        glow.bricks.push_back(temperature.bricks[b]);
        std::transform(begin, begin + VoxelGrid::kBrickVoxels, std::back_inserter(glow.values),
                       luminance);
    }
    for (VoxelTile tile : temperature.tiles) {
        tile.value = glm::vec3(luminance(tile.value.x), 0, 0);
        if (tile.value.x == 0)
            continue;
        add(tile.brick_min, tile.brick_max, tile.value.x);
        glow.tiles.push_back(tile);
    }
    if (glow.max_value == 0) {
        glow.index_min = glm::ivec3(1);
        glow.index_max = glm::ivec3(0);
    } else {  // whole bricks may reach past the grid
        glow.index_min = glm::max(glow.index_min, temperature.index_min);
        glow.index_max = glm::min(glow.index_max, temperature.index_max);
    }
    return std::make_shared<const VoxelGrid>(std::move(glow));
}

/// How hot what is shown is, and whether that is hot enough to glow.
struct Heat {
    std::string name;  ///< "" if there is no temperature
    double most = 0;   ///< the largest value
    double kelvin = 1000;
    bool glows = false;
};

Heat heat_of(const std::vector<Shown>& shown)
{
    GridMedium medium;
    for (const Shown& one : shown)
        if (one.temperature && !one.temperature->empty() &&
            (!medium.temperature || medium.temperature->max_value < one.temperature->max_value))
            medium.temperature = one.temperature;
    if (!medium.temperature)
        return {};
    const auto most = static_cast<double>(medium.temperature->max_value);
    const double kelvin = kelvin_per_unit(medium);
    // Smoke that only rises is given a warmth of up to 1 by those who don't count in kelvin.
    const bool glows = kelvin == 1 ? most > kDraperKelvin : most > 1;
    return {medium.temperature->name, most, kelvin, glows};
}

/// Gives temperatures the light of a blackbody, if they are those of something that glows.
/// @returns kelvin per unit, or 0 if they are not
double light_up(std::vector<Shown>& shown, std::vector<std::string>& notes)
{
    const Heat heat = heat_of(shown);
    if (heat.name.empty())
        return 0;
    notes.push_back(fmt::format(
        "grid '{}' holds up to {:.4g}, taken as {}: {:.4g} K at most, {}", heat.name, heat.most,
        heat.kelvin == 1 ? "kelvin" : "thousands of kelvin", heat.kelvin * heat.most,
        heat.glows ? "glows as a blackbody" : "too cold to glow as a blackbody"));
    if (!heat.glows)
        return 0;
    for (Shown& one : shown)
        one.emission = one.temperature && !one.temperature->empty()
                           ? blackbody_grid(*one.temperature, heat.kelvin)
                           : nullptr;
    return heat.kelvin;
}

/// What a metre of a value of 1 adds to the picture, where 1 in all is a lot.
struct PerValue {
    double density, emission;
};

/// A grid and the least of its values that is seen.
struct Content {
    const VoxelGrid* grid;
    double least;

    Content(const VoxelGrid& of, double per_value)
        : grid(&of),
          // A line of sight all through the grid at this value adds kUnseen. But something is seen.
          least(std::min(kUnseen / (per_value * largest(world_bounds(of).size())),
                         static_cast<double>(of.max_value) / of.channels))
    {
    }
};

void include(Reach& reach, const Shown& shown, const PerValue& per_value)
{
    const auto add = [&](const std::shared_ptr<const VoxelGrid>& grid, double per) {
        if (grid && !grid->empty())
            reach.include(*grid, Content(*grid, per).least);
    };
    add(shown.density, per_value.density);
    add(shown.emission, per_value.emission);
}

/// Frames of a sequence that were not read: how far their grids reach at most, by the headers of
/// their files. What matters of them is read after all.
class Unread {
public:
    struct Extent {
        glm::dmat4 world_from_index{1};
        Box voxels;
    };
    struct Frame {
        int frame;
        std::vector<Extent> extents;
        std::uint64_t bytes;
    };
    using Read = std::function<Shown(int frame)>;

    Unread() = default;
    /// @param most_bytes of files that may be read
    Unread(std::vector<Frame> frames, Read read, std::uint64_t most_bytes)
        : frames_(std::move(frames)), read_(std::move(read)), bytes_left_(most_bytes)
    {
    }

    /// Takes in all frames: of those that reach out of the others' content the content, as long as
    /// there are bytes left, else what the headers say, which may be more.
    void include_in(Reach& reach, const PerValue& per_value)
    {
        while (!frames_.empty()) {
            const auto excess = [&](const Frame& frame) {
                double most = -std::numeric_limits<double>::infinity();
                for (const Extent& extent : frame.extents)
                    most = std::max(most, reach.excess(extent.world_from_index, extent.voxels));
                return most;
            };
            const auto farthest = std::max_element(
                frames_.begin(), frames_.end(),
                [&](const Frame& a, const Frame& b) { return excess(a) < excess(b); });
            if (excess(*farthest) <= 0)
                return;
            if (farthest->bytes <= bytes_left_) {
                bytes_left_ -= farthest->bytes;
                include(reach, read_(farthest->frame), per_value);
            } else {
                for (const Extent& extent : farthest->extents)
                    reach.include(extent.world_from_index, extent.voxels);
            }
            frames_.erase(farthest);
        }
    }

private:
    std::vector<Frame> frames_;
    Read read_;
    std::uint64_t bytes_left_ = 0;
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
Framing frame(const std::vector<Shown>& shown, Unread unread, const PerValue& per_value,
              const Axes& axes, double aspect)
{
    const double azimuth = glm::radians(kAzimuthDeg), elevation = glm::radians(kElevationDeg);
    const glm::dvec3 to_camera =
        axes.world({std::cos(elevation) * std::sin(azimuth),
                    std::cos(elevation) * std::cos(azimuth), std::sin(elevation)});
    const glm::dvec3 right = glm::normalize(glm::cross(axes.up, to_camera));
    const glm::dvec3 up = glm::cross(to_camera, right);
    const double slope_y = kFill * std::tan(glm::radians(kVfovDeg / 2));
    const double slope_x = slope_y * aspect;

    const auto seen = std::find_if(shown.begin(), shown.end(), [](const Shown& frame) {
        return frame.density && !frame.density->empty();
    });
    const glm::dvec3 center = world_bounds(*seen->density).center();
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
    for (const Shown& one : shown)
        include(reach, one, per_value);
    unread.include_in(reach, per_value);

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
    camera.far = three_digits(kFar * distance);
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

/// Solves mean(1 - exp(-sigma_t * column)) = opacity.
double sigma_t_for_opacity(const std::vector<WeightedColumn>& columns, double opacity)
{
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

/// Columns of one grid of all that is shown.
std::vector<WeightedColumn> columns_of(const std::vector<Shown>& shown,
                                       std::shared_ptr<const VoxelGrid> Shown::*which)
{
    std::vector<WeightedColumn> all;
    for (const Shown& one : shown)
        if (const VoxelGrid* grid = (one.*which).get(); grid != nullptr && !grid->empty()) {
            const std::vector<WeightedColumn> own = content_columns(*grid);
            all.insert(all.end(), own.begin(), own.end());
        }
    return all;
}

/// The coefficient of a density that makes its average line of sight `opacity` opaque.
/// @throws Error if no scene may have it
double fitted_extinction(const std::vector<WeightedColumn>& columns, double opacity,
                         const std::string& file, const std::string& grid)
{
    const double sigma_t = sigma_t_for_opacity(columns, opacity);
    if (sigma_t > kCoefficient.max)
        throw Error(fmt::format("{}: grid '{}' is next to nothing: it would take {:.3g} /m per "
                                "density to be seen, and {:.0e} is the most; multiply it, or name "
                                "another grid",
                                file, grid, sigma_t, kCoefficient.max));
    return sigma_t;
}

/// Gives a medium this extinction on average over the channels. Its colour and the albedo stay.
void set_extinction(GridMedium& medium, double sigma_t)
{
    const glm::dvec3 was(medium.sigma_s_per_density + medium.sigma_a_per_density);
    const double mean = (was.x + was.y + was.z) / 3;
    for (int c = 0; c < 3; ++c) {
        const double albedo =
            was[c] > 0 ? static_cast<double>(medium.sigma_s_per_density[c]) / was[c] : kAlbedo;
        const double now = mean > 0 ? sigma_t * was[c] / mean : sigma_t;
        medium.sigma_s_per_density[c] = static_cast<float>(three_digits(albedo * now));
        medium.sigma_a_per_density[c] = static_cast<float>(three_digits((1 - albedo) * now));
    }
}

/// Luminance of smoke that the sun lights: what is opaque and lit from the side gives about
/// irradiance / 4 pi.
double sunlit_smoke()
{
    return glm::dot(glm::dvec3(kSunIrradiance), kLuminance) / (4 * glm::pi<double>());
}

/// Luminance that a metre of a value of 1 is given, for bright lines of sight through what glows to
/// outshine sunlit smoke.
double fitted_glow(const std::vector<WeightedColumn>& columns)
{
    return kFireOverSmoke * sunlit_smoke() / column_quantile(columns, kBrightShare);
}

/// emission_per_unit of that luminance. The colour is the grid's own where it has three channels.
glm::vec3 glow_color(const VoxelGrid& grid, double luminance_per_unit)
{
    const glm::dvec3 color = grid.channels == 3 ? glm::dvec3(1) : glm::dvec3(kFireColor);
    return three_digits(color * (luminance_per_unit / glm::dot(color, kLuminance)));
}

/// What a scene's medium is called, and the largest value of its colour grid.
struct Names {
    std::string file;
    std::string density, emission;
    double brightest_color = 1;
    double kelvin = 0;  ///< per unit of `emission`, which is a temperature; 0: it is none

    /// Of the average line of sight. A flame that is its own smoke is fire alone.
    [[nodiscard]] double opacity() const { return emission == density ? kFireOpacity : kOpacity; }
};

/// A scene for grids at hand and for what is not read of a sequence. A density at hand holds
/// something.
LoadedScene compose(const std::vector<Shown>& shown, Unread unread, const Names& names, char up,
                    glm::uvec2 resolution)
{
    assert(up == 'y' || up == 'z');
    LoadedScene loaded;
    std::vector<std::string>& notes = loaded.notes;

    GridMedium medium;
    medium.grid = names.density;
    medium.g = kG;
    const double sigma_t = fitted_extinction(columns_of(shown, &Shown::density), names.opacity(),
                                             names.file, names.density);
    // A colour above 1 must not scatter more than is lost.
    const double albedo = kAlbedo / std::max(1.0, names.brightest_color);
    medium.sigma_s_per_density = three_digits(glm::dvec3(albedo * sigma_t));
    medium.sigma_a_per_density = three_digits(glm::dvec3((1 - albedo) * sigma_t));
    PerValue per_value{sigma_t, 0};
    notes.push_back(
        fmt::format("coefficient {:.3g} /m per density: average line of sight {:.0f} % opaque",
                    sigma_t, 100 * names.opacity()));

    if (const std::vector<WeightedColumn> columns = columns_of(shown, &Shown::emission);
        !columns.empty()) {
        const auto lit = std::find_if(shown.begin(), shown.end(), [](const Shown& one) {
            return one.emission && !one.emission->empty();
        });
        const double luminance_per_unit = fitted_glow(columns);
        per_value.emission = luminance_per_unit / sunlit_smoke();
        std::string how;
        if (names.kelvin > 0) {
            medium.temperature_grid = names.emission;
            medium.temperature_scale = names.kelvin;
            medium.blackbody_intensity = three_digits(glm::dvec3(luminance_per_unit)).x;
            how = fmt::format("blackbody_intensity {:.3g}", medium.blackbody_intensity);
        } else {
            medium.emission_grid = names.emission;
            medium.emission_per_unit = glow_color(*lit->emission, luminance_per_unit);
            how = fmt::format("{:.3g} W/m^2/sr per metre per unit in red",
                              medium.emission_per_unit.r);
        }
        notes.push_back(fmt::format("grid '{}' glows: {}: a bright line of sight through it is "
                                    "{:.2g} times as bright as sunlit smoke",
                                    names.emission, how, kFireOverSmoke));
    }

    const Axes axes(up);
    const Framing framing =
        frame(shown, std::move(unread), per_value, axes,
              static_cast<double>(resolution.x) / static_cast<double>(resolution.y));
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

// --- Which grids --------------------------------------------------------------------------------

std::string base_name(const GridInfo& grid)
{
    return lower_case(without_number(grid.name));
}

bool is_vector(const GridInfo& grid)
{
    return grid.value_type.starts_with("vec3");
}

std::string quoted(const std::vector<std::string>& names)
{
    constexpr std::size_t kMost = 12;
    std::string text;
    for (std::size_t i = 0; i < std::min(kMost, names.size()); ++i)
        text += fmt::format("{}'{}'", i ? ", " : "", names[i]);
    if (names.size() > kMost)
        text += fmt::format(" and {} more", names.size() - kMost);
    return text;
}

/// Which grid of which was taken, and which are not shown.
void tell_grids(const VdbInfo& file, const GridMedium& medium, std::vector<std::string>& notes)
{
    std::vector<std::string> all, rest;
    const std::string color = lower_case(medium.color_grid);
    for (const GridInfo& grid : file.grids) {
        all.push_back(grid.name);
        const bool channel_of_color = !color.empty() && !is_vector(grid) &&
                                      base_name(grid).starts_with(color) &&
                                      base_name(grid).size() <= color.size() + 2;
        if (grid.name != medium.grid && grid.name != medium.emission_grid &&
            grid.name != medium.color_grid && grid.name != medium.temperature_grid &&
            !channel_of_color)
            rest.push_back(grid.name);
    }
    const auto smoke = std::find_if(file.grids.begin(), file.grids.end(),
                                    [&](const GridInfo& grid) { return grid.name == medium.grid; });
    if (all.size() > 1)
        notes.push_back(fmt::format("grid '{}' is the smoke, of {}", medium.grid, quoted(all)));
    const bool glows =
        medium.grid == medium.emission_grid || medium.grid == medium.temperature_grid;
    if (glows || (all.size() == 1 && smoke != file.grids.end() &&
                  !like_smoke(base_name(*smoke), smoke->grid_class)))
        notes.push_back(fmt::format("grid '{}' is drawn as {}, for the file has no smoke",
                                    medium.grid, glows ? "fire alone" : "smoke"));
    if (!medium.color_grid.empty())
        notes.push_back(fmt::format("grid '{}' colours it", medium.color_grid));
    if (!rest.empty())
        notes.push_back(fmt::format("not shown: {}", quoted(rest)));
}

char choose_up(const AutoSceneOptions& options, const VdbInfo& file, const glm::dvec3& size,
               std::vector<std::string>& notes)
{
    if (options.up != 0)
        return options.up;
    const UpGuess guess = guess_up(file, size);
    notes.push_back(fmt::format("{} is up ({})", guess.axis, guess.why));
    return guess.axis;
}

// --- A sequence ---------------------------------------------------------------------------------

/// Of files that are read for their values before the first picture.
constexpr std::uint64_t kMostBytes = 128U << 20U;
constexpr std::size_t kSamples = 5;  // frames whose values make the coefficients

/// Its grids, and where its frames have something of them.
class Sequence {
public:
    Sequence(const fs::path& pattern, const AutoSceneOptions& options)
        : pattern_(pattern), frames_(read_sequence(pattern)), all_(all_grids(frames_))
    {
        choose_density(options.grid);
        emission_ = guess_emission_grid(all_, density_);
        temperature_ = guess_temperature_grid(all_, density_);
        color_ = guess_color_grid(all_, density_);
    }

    [[nodiscard]] LoadedScene scene(const AutoSceneOptions& options) const;

private:
    void choose_density(const std::string& wanted)
    {
        if (!wanted.empty()) {
            if (!has_grid(all_, wanted))
                fail(fmt::format("no frame has a grid '{}'", wanted));
            density_ = wanted;
        } else {
            for (const GridInfo* grid : fog_candidates(all_))
                if (density_.empty() && grid->active_voxels > 0)
                    density_ = grid->name;
        }
        if (density_.empty() || voxels_in(all_, density_) == 0)
            fail(density_.empty() ? "nothing to take as fog in any frame"
                                  : fmt::format("grid '{}' is empty in all frames", density_));
    }
    [[noreturn]] void fail(const std::string& why) const
    {
        std::vector<std::string> names;
        for (const GridInfo& grid : all_.grids)
            names.push_back(grid.name);
        throw Error(fmt::format("{}: {} (has: {})", pattern_.string(), why, quoted(names)));
    }

    [[nodiscard]] Shown read(const SequenceFrame& frame, std::vector<std::string>* notes) const;
    [[nodiscard]] std::vector<const SequenceFrame*> samples() const;
    /// @param kelvin per unit of the temperature, if that is what glows; else 0
    [[nodiscard]] Unread unread(const std::vector<const SequenceFrame*>& known,
                                double kelvin) const;

    fs::path pattern_;
    std::vector<SequenceFrame> frames_;
    VdbInfo all_;
    std::string density_, emission_, color_, temperature_;
};

Shown Sequence::read(const SequenceFrame& frame, std::vector<std::string>* notes) const
{
    const auto load = [&](const std::string& name) -> std::shared_ptr<const VoxelGrid> {
        if (name.empty() || voxels_in(frame.file, name) == 0)
            return nullptr;
        LoadedGrid loaded = load_grid(frame_file(pattern_, frame.frame), name);
        if (notes != nullptr)
            notes->insert(notes->end(), loaded.notes.begin(), loaded.notes.end());
        return std::make_shared<const VoxelGrid>(std::move(loaded.grid));
    };
    try {
        Shown one{load(density_), load(emission_), nullptr};
        one.temperature = temperature_ == emission_ ? one.emission : load(temperature_);
        return one;
    } catch (const Error&) {
        return {};  // a broken frame is told of when it is shown
    }
}

/// The fullest frame of either grid, and some from first to last.
std::vector<const SequenceFrame*> Sequence::samples() const
{
    std::vector<const SequenceFrame*> held;
    for (const SequenceFrame& frame : frames_)
        if (voxels_in(frame.file, density_) > 0)
            held.push_back(&frame);
    const auto fullest = [&](const std::string& name) {
        return &*std::max_element(frames_.begin(), frames_.end(),
                                  [&](const SequenceFrame& a, const SequenceFrame& b) {
                                      return voxels_in(a.file, name) < voxels_in(b.file, name);
                                  });
    };
    std::vector<const SequenceFrame*> wanted{fullest(density_)};
    for (const std::string& glow : {emission_, temperature_})
        if (!glow.empty())
            wanted.push_back(fullest(glow));
    const std::size_t count = std::min(kSamples, held.size());
    for (std::size_t i = 0; i < count; ++i)
        wanted.push_back(held[count == 1 ? 0 : i * (held.size() - 1) / (count - 1)]);
    std::vector<const SequenceFrame*> chosen;
    std::uint64_t bytes = 0;
    for (const SequenceFrame* frame : wanted)
        if (std::find(chosen.begin(), chosen.end(), frame) == chosen.end() &&
            (chosen.empty() || bytes + frame->file.file_bytes <= kMostBytes)) {
            chosen.push_back(frame);
            bytes += frame->file.file_bytes;
        }
    return chosen;
}

Unread Sequence::unread(const std::vector<const SequenceFrame*>& known, double kelvin) const
{
    const std::string& glow = kelvin > 0 ? temperature_ : emission_;
    std::vector<Unread::Frame> frames;
    for (const SequenceFrame& frame : frames_) {
        if (std::find(known.begin(), known.end(), &frame) != known.end())
            continue;
        Unread::Frame of{frame.frame, {}, frame.file.file_bytes};
        for (const GridInfo& grid : frame.file.grids)
            if ((grid.name == density_ || grid.name == glow) && grid.active_voxels > 0)
                of.extents.push_back({grid.world_from_index,
                                      Box{glm::dvec3(grid.index_min), glm::dvec3(grid.index_max)}});
        if (!of.extents.empty())
            frames.push_back(std::move(of));
    }
    return {std::move(frames),
            [this, kelvin](int number) {
                const auto frame =
                    std::find_if(frames_.begin(), frames_.end(),
                                 [&](const SequenceFrame& f) { return f.frame == number; });
                Shown one = read(*frame, nullptr);
                if (kelvin > 0)
                    one.emission =
                        one.temperature ? blackbody_grid(*one.temperature, kelvin) : nullptr;
                return one;
            },
            kMostBytes};
}

LoadedScene Sequence::scene(const AutoSceneOptions& options) const
{
    std::vector<std::string> notes;
    std::vector<Shown> shown;
    std::vector<const SequenceFrame*> known;
    std::string numbers;
    std::uint64_t bytes = 0;
    const auto know = [&](const SequenceFrame& frame) {
        Shown one = read(frame, &notes);
        known.push_back(&frame);
        bytes += frame.file.file_bytes;
        if (one.density && !one.density->empty())
            numbers += fmt::format("{}{}", numbers.empty() ? "" : ", ", frame.frame);
        shown.push_back(std::move(one));
    };
    for (const SequenceFrame* frame : samples())
        know(*frame);
    // Where none of these burns, another may.
    for (const SequenceFrame& frame : frames_)
        if (!temperature_.empty() && !heat_of(shown).glows &&
            voxels_in(frame.file, temperature_) > 0 &&
            std::find(known.begin(), known.end(), &frame) == known.end() &&
            bytes + frame.file.file_bytes <= kMostBytes)
            know(frame);
    if (numbers.empty())
        fail(fmt::format("grid '{}' is 0 everywhere", density_));

    const double kelvin = light_up(shown, notes);

    glm::dvec3 least(std::numeric_limits<double>::infinity()), most(-least);
    for (const SequenceFrame& frame : frames_)
        for (const GridInfo& grid : frame.file.grids)
            if (grid.name == density_ && grid.active_voxels > 0) {
                least = glm::min(least, grid.world_min);
                most = glm::max(most, grid.world_max);
            }
    VdbInfo fullest = all_;
    try {
        // Its velocities are worth a look at their values.
        fullest = inspect_vdb(frame_file(pattern_, known.front()->frame));
    } catch (const Error&) {
    }
    if (fullest.creator.empty())
        fullest.creator = all_.creator;
    const char up = choose_up(options, fullest, most - least, notes);

    Names names{pattern_.string(), density_, kelvin > 0 ? temperature_ : emission_, 1, kelvin};
    for (const SequenceFrame* frame : known) {
        if (color_.empty() || voxels_in(frame->file, color_) == 0)
            continue;
        try {
            const double brightest = static_cast<double>(
                load_grid(frame_file(pattern_, frame->frame), color_).grid.max_value);
            names.brightest_color = std::max(names.brightest_color, brightest);
        } catch (const Error&) {
        }
    }
    LoadedScene loaded = compose(shown, unread(known, kelvin), names, up, options.resolution);
    auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    medium.file = pattern_.string();
    medium.color_grid = color_;
    tell_grids(all_, medium, notes);
    loaded.notes.insert(loaded.notes.begin(), notes.begin(), notes.end());
    loaded.notes.push_back(fmt::format("fitted to {} frames, {} to {}; coefficients by frame{} {}",
                                       frames_.size(), frames_.front().frame, frames_.back().frame,
                                       numbers.find(',') == std::string::npos ? "" : "s", numbers));
    return loaded;
}

/// As simulators call what burns; the first that holds something is meant.
const std::vector<std::string_view>& flame_names()
{
    static const std::vector<std::string_view> names{"flame", "flames",  "fire",
                                                     "burn",  "burning", "emission"};
    return names;
}

/// The first of `names` that has something beside `density`, in fewer voxels than `most`; or "".
std::string find_glow(const VdbInfo& file, const std::string& density,
                      const std::vector<std::string_view>& names,
                      double most = std::numeric_limits<double>::infinity())
{
    for (const std::string_view name : names)
        for (const GridInfo& grid : file.grids)
            if (base_name(grid) == name && grid.name != density && grid.refusal.empty() &&
                grid.active_voxels > 0 && grid.max > 0 &&
                static_cast<double>(grid.active_voxels) < most)
                return grid.name;
    return "";
}

/// Whether what was taken for the smoke is one of `names`, as nothing in the file is like smoke.
bool is_all_there_is(const VdbInfo& file, const std::string& density,
                     const std::vector<std::string_view>& names)
{
    bool found = false;
    for (const GridInfo& grid : file.grids) {
        const std::string name = base_name(grid);
        if (grid.name == density)
            found = std::find(names.begin(), names.end(), name) != names.end();
        else if (!is_vector(grid) && grid.active_voxels > 0 && grid.max > 0 &&
                 like_smoke(name, grid.grid_class))
            return false;
    }
    return found;
}

}  // namespace

double sigma_t_for_opacity(const VoxelGrid& grid, double opacity)
{
    assert(!grid.empty() && opacity > 0 && opacity < 1);
    return sigma_t_for_opacity(content_columns(grid), opacity);
}

void fit_medium(GridMedium& medium, NewGrids which)
{
    const auto content = [&](const std::shared_ptr<const VoxelGrid>& grid) {
        if (grid->empty())
            throw Error(fmt::format("{}: grid '{}' is 0 everywhere: nothing to show; take another",
                                    medium.file, grid->name));
        return content_columns(*grid);
    };
    if (which.density) {
        const double sigma_t =
            fitted_extinction(content(medium.density), kOpacity, medium.file, medium.density->name);
        set_extinction(medium, sigma_t);
    }
    if (which.emission)
        medium.emission_per_unit =
            glow_color(*medium.emission, fitted_glow(content(medium.emission)));
    if (which.temperature) {
        static_cast<void>(content(medium.temperature));
        medium.temperature_scale = kelvin_per_unit(medium);
        // What is too cold glows by no factor.
        const auto glow = blackbody_grid(*medium.temperature, medium.temperature_scale);
        if (!glow->empty())
            medium.blackbody_intensity =
                static_cast<float>(three_digits(fitted_glow(content_columns(*glow))));
    }
}

std::string guess_emission_grid(const VdbInfo& file, const std::string& density)
{
    std::string flame = find_glow(file, density, flame_names());
    if (!flame.empty())
        return flame;
    if (is_all_there_is(file, density, flame_names()))
        return density;
    // Hot is not burning: a solver's temperature fills all of its smoke. Where it is a part of it,
    // it marks the source.
    const auto smoke = std::find_if(file.grids.begin(), file.grids.end(),
                                    [&](const GridInfo& grid) { return grid.name == density; });
    if (smoke == file.grids.end())
        return "";
    return find_glow(file, density, temperature_names(),
                     0.6 * static_cast<double>(smoke->active_voxels));
}

std::string guess_temperature_grid(const VdbInfo& file, const std::string& density)
{
    if (!find_glow(file, density, flame_names()).empty())
        return "";
    const std::string other = find_glow(file, density, temperature_names());
    return other.empty() && is_all_there_is(file, density, temperature_names()) ? density : other;
}

std::string guess_color_grid(const VdbInfo& file, const std::string& density)
{
    // What holds less than nothing was made for another use than to tint: a nebula's emission.
    const auto can_tint = [](const GridInfo& grid) {
        return grid.refusal.empty() && grid.negative_count == 0;
    };
    std::vector<GridName> names;
    for (const GridInfo& grid : file.grids)
        names.push_back({grid.name, std::string(without_number(grid.name))});
    for (const std::string_view name : color_names()) {
        for (const GridInfo& grid : file.grids)
            if (base_name(grid) == name && is_vector(grid) && grid.name != density &&
                can_tint(grid) && grid.active_voxels > 0)
                return grid.name;
        const auto channels = find_channels(names, name);
        if (channels && std::all_of(channels->begin(), channels->end(), [&](std::size_t c) {
                return can_tint(file.grids[c]) && !is_vector(file.grids[c]) &&
                       file.grids[c].world_from_index ==
                           file.grids[channels->front()].world_from_index;
            }))
            return file.grids[channels->front()].name.substr(0, name.size());
    }
    return "";
}

UpGuess guess_up(const VdbInfo& file, const glm::dvec3& size)
{
    const std::string who = lower_case(file.creator);
    const std::string by = "written by " + printable(file.creator);
    if (who.find("blender") != std::string::npos || who.find("mantaflow") != std::string::npos)
        return {'z', by};
    if (who.find("houdini") != std::string::npos)
        return {'y', by};
    const auto has = [&](const char* name) {
        return std::any_of(file.grids.begin(), file.grids.end(),
                           [&](const GridInfo& grid) { return grid.name == name; });
    };
    // Mantaflow, which Blender has inside, keeps what its preview needs beside the smoke.
    if (has("density") && has("shadow") && (has("flame") || has("temperature") || has("heat")))
        return {'z', "grids 'density', 'shadow' and 'flame', as Blender's simulations have them"};
    for (const GridInfo& grid : file.grids) {
        const std::string name = base_name(grid);
        if (!is_vector(grid) || (name != "velocity" && name != "vel" && name != "v"))
            continue;
        // Smoke rises.
        const glm::dvec3 mean = grid.mean_vector;
        const auto rises = [&](double up, double other) {
            return up > 1.5 * std::max(std::abs(other), std::abs(mean.x));
        };
        if (rises(mean.z, mean.y))
            return {'z', fmt::format("grid '{}' rises in z", grid.name)};
        if (rises(mean.y, mean.z))
            return {'y', fmt::format("grid '{}' rises in y", grid.name)};
    }
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
    assert(density && !density->empty());
    LoadedScene loaded =
        compose({{density, emission, nullptr}}, {},
                {"the grids", density->name, emission ? emission->name : "", 1, 0}, up, resolution);
    auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    medium.density = std::move(density);
    medium.emission = std::move(emission);
    return loaded;
}

LoadedScene make_auto_scene(const fs::path& vdb, const AutoSceneOptions& options)
{
    if (is_sequence(vdb))
        return Sequence(vdb, options).scene(options);
    LoadedGrid density = load_grid(vdb, options.grid);
    if (density.grid.empty())
        throw Error(fmt::format("{}: grid '{}' is 0 everywhere: nothing to show; name another grid",
                                vdb.string(), density.grid.name));
    const VdbInfo info = inspect_vdb(vdb);

    std::vector<std::string> notes = std::move(density.notes);
    auto grid = std::make_shared<const VoxelGrid>(std::move(density.grid));
    const auto read = [&](const std::string& name) -> std::shared_ptr<const VoxelGrid> {
        if (name.empty())
            return nullptr;
        if (name == grid->name)
            return grid;
        LoadedGrid loaded = load_grid(vdb, name);
        notes.insert(notes.end(), loaded.notes.begin(), loaded.notes.end());
        return std::make_shared<const VoxelGrid>(std::move(loaded.grid));
    };
    const std::string flame = guess_emission_grid(info, grid->name),
                      heat = guess_temperature_grid(info, grid->name);
    std::vector<Shown> shown{{grid, read(flame), nullptr}};
    shown.front().temperature = heat == flame ? shown.front().emission : read(heat);
    const std::shared_ptr<const VoxelGrid> emission = shown.front().emission,
                                           temperature = shown.front().temperature,
                                           color = read(guess_color_grid(info, grid->name));
    const double kelvin = light_up(shown, notes);
    const std::string glow = kelvin > 0 ? temperature->name : emission ? emission->name : "";
    const char up = choose_up(options, info, world_bounds(*grid).size(), notes);

    const bool colored = color && !color->empty();
    LoadedScene loaded = compose(shown, {},
                                 {vdb.string(), grid->name, glow,
                                  colored ? static_cast<double>(color->max_value) : 1, kelvin},
                                 up, options.resolution);
    auto& medium = std::get<GridMedium>(loaded.scene.media.front());
    medium.file = vdb.string();
    medium.density = grid;
    (kelvin > 0 ? medium.temperature : medium.emission) = kelvin > 0 ? temperature : emission;
    if (colored) {
        medium.color = color;
        medium.color_grid = color->name;
    }
    tell_grids(info, medium, notes);
    loaded.notes.insert(loaded.notes.begin(), notes.begin(), notes.end());
    return loaded;
}

}  // namespace fumarole::asset
