#include "medium/media_set.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <limits>

#include "blackbody.h"
#include "medium/noise_grid.h"
#include "noise_gradient.h"
#include "overloaded.h"
#include <fumarole/errors.h>

namespace fumarole::medium {

namespace {

using Profile = MediumSource::Profile;
using Depth = MediumSource::Depth;

bool is_zero(glm::vec3 v)
{
    return v == glm::vec3(0.0f);
}
bool is_grey(glm::vec3 v)
{
    return v.r == v.g && v.g == v.b;
}
float mean(glm::vec3 v)
{
    return (v.r + v.g + v.b) / 3.0f;
}

using Kind = GridSource::Kind;

constexpr std::size_t kMostBoxes = 4096;  // of a grid: projecting so many takes half a millisecond

struct TexelFormat {
    GLenum internal, format, type;
};

TexelFormat texel_format(const GridLayout& layout)
{
    const bool color = layout.channels == 4;
    const GLenum format = color ? GL_RGBA : GL_RED;
    switch (layout.storage) {
    case Storage::r8:
        return {static_cast<GLenum>(color ? GL_RGBA8 : GL_R8), format, GL_UNSIGNED_BYTE};
    case Storage::r16f:
        return {static_cast<GLenum>(color ? GL_RGBA16F : GL_R16F), format, GL_HALF_FLOAT};
    default:
        return {static_cast<GLenum>(color ? GL_RGBA32F : GL_R32F), format, GL_FLOAT};
    }
}

shared::MediumParams coefficients(glm::vec3 sigma_s, glm::vec3 sigma_a, glm::vec3 emission, float g)
{
    const glm::vec3 sigma_t = sigma_s + sigma_a;
    shared::MediumParams params{};
    params.sigma_s = sigma_s;
    params.g = g;
    params.sigma_t = glm::vec4(sigma_t, is_grey(sigma_t) ? sigma_t.r : mean(sigma_t));
    params.emission = emission;
    params.light_dimming = 1;
    return params;
}

/// What of a medium's grids is seen.
struct Use {
    explicit Use(const GridMedium& medium)
        : dims{!is_zero(medium.sigma_s_per_density + medium.sigma_a_per_density) &&
               is_there(medium.density)},
          glows{!is_zero(medium.emission_per_unit) && is_there(medium.emission)},
          hot{glows_hot(medium)}, tinted{dims && !is_zero(medium.sigma_s_per_density)}
    {
    }
    static bool is_there(const std::shared_ptr<const VoxelGrid>& grid)
    {
        return grid != nullptr && !grid->empty();
    }
    bool dims, glows, hot, tinted;
};

/// With what a temperature is stored: a byte's error would be four times as large in its light.
SceneSettings for_temperature(SceneSettings settings)
{
    if (settings.storage == Storage::automatic)
        settings.storage = Storage::r16f;
    return settings;
}

/// A scene's grids and how each is stored.
std::vector<std::pair<std::shared_ptr<const VoxelGrid>, SceneSettings>>
grids_of(const Scene& scene, const SceneSettings& settings)
{
    std::vector<std::pair<std::shared_ptr<const VoxelGrid>, SceneSettings>> all;
    for (const Medium& one : scene.media) {
        const auto* medium = std::get_if<GridMedium>(&one);
        if (medium == nullptr)
            continue;
        const Use use(*medium);
        const auto add = [&](bool used, const std::shared_ptr<const VoxelGrid>& grid,
                             const SceneSettings& own) {
            if (used && Use::is_there(grid))
                all.emplace_back(grid, own);
        };
        add(use.dims, medium->density, settings);
        add(use.glows, medium->emission, settings);
        add(use.hot, medium->temperature, for_temperature(settings));
        add(use.tinted, medium->color, settings);
    }
    return all;
}

}  // namespace

MediaSet::Grid MediaSet::make_grid(const std::shared_ptr<const VoxelGrid>& grid,
                                   const SceneSettings& settings) const
{
    const Limits limits{.max_texture_3d = device_.capabilities().max_texture_3d};
    Grid made;
    made.source = grid;
    made.asked_layout = settings.layout;
    made.asked_storage = settings.storage;
    made.plan = make_layout(*grid, settings.layout, settings.storage, limits);
    made.texels = gl::Texture::make_3d(device_, grid->name + " texels", made.plan.texture_size,
                                       texel_format(made.plan).internal, gl::Filter::linear);
    if (made.plan.layout == Layout::bricks)
        made.pages = gl::Texture::make_3d(device_, grid->name + " pages", made.plan.page_count,
                                          GL_R32UI, gl::Filter::nearest);
    return made;
}

std::uint64_t MediaSet::send(Grid& grid, std::uint64_t most, bool row)
{
    std::uint64_t sent = 0;
    const auto send_rows = [&](gl::Texture& to, GLenum format, GLenum type, const void* data,
                               std::size_t bytes, std::size_t& rows) {
        const std::size_t of_row = bytes / to.rows();
        while (rows < to.rows() && ((row && sent == 0) || sent + of_row <= most)) {
            const std::size_t now =
                to.stage_rows(format, type, static_cast<const std::uint8_t*>(data), of_row, rows,
                              static_cast<std::size_t>(most - std::min(sent, most)));
            rows += now;
            sent += now * of_row;
        }
    };
    const TexelFormat format = texel_format(grid.plan);
    send_rows(grid.texels, format.format, format.type, grid.plan.texels.data(),
              grid.plan.texels.size(), grid.texel_rows);
    if (grid.pages && grid.texel_rows == grid.texels.rows())
        send_rows(grid.pages, GL_RED_INTEGER, GL_UNSIGNED_INT, grid.plan.pages.data(),
                  grid.plan.pages.size() * sizeof(grid.plan.pages[0]), grid.page_rows);
    if (grid.is_sent()) {
        grid.plan.texels = {};
        grid.plan.pages = {};
        ++uploads_;
    }
    sent_bytes_ += sent;
    return sent;
}

int MediaSet::upload(const std::shared_ptr<const VoxelGrid>& grid, const SceneSettings& settings)
{
    const auto same = [&](const Grid& one) { return one.is(grid, settings); };
    if (const auto found = std::find_if(grids_.begin(), grids_.end(), same); found != grids_.end())
        return static_cast<int>(found - grids_.begin());
    const auto take = [&](std::vector<Grid>& from) {
        const auto found = std::find_if(from.begin(), from.end(), same);
        if (found == from.end())
            return false;
        grids_.push_back(std::move(*found));
        from.erase(found);
        return true;
    };
    if (!take(old_grids_) && !take(sending_))
        grids_.push_back(make_grid(grid, settings));
    while (!grids_.back().is_sent())
        send(grids_.back(), std::numeric_limits<std::uint64_t>::max(), true);
    return static_cast<int>(grids_.size()) - 1;
}

void MediaSet::begin_sending(const Scene& scene, const SceneSettings& settings)
{
    std::vector<Grid> before = std::move(sending_);
    sending_.clear();
    for (const auto& [grid, own] : grids_of(scene, settings)) {
        const auto same = [&, &asked = grid, &how = own](const Grid& one) {
            return one.is(asked, how);
        };
        if (std::any_of(grids_.begin(), grids_.end(), same) ||
            std::any_of(sending_.begin(), sending_.end(), same))
            continue;
        if (const auto found = std::find_if(before.begin(), before.end(), same);
            found != before.end())
            sending_.push_back(std::move(*found));
        else
            sending_.push_back(make_grid(grid, own));
    }
}

std::uint64_t MediaSet::send(std::uint64_t most, bool row)
{
    std::uint64_t sent = 0;
    for (Grid& grid : sending_)
        if (!grid.is_sent())
            sent += send(grid, most - std::min(sent, most), row && sent == 0);
    return sent;
}

bool MediaSet::is_sending() const
{
    return !std::all_of(sending_.begin(), sending_.end(),
                        [](const Grid& grid) { return grid.is_sent(); });
}

bool MediaSet::has_grids(const Scene& scene, const SceneSettings& settings) const
{
    for (const auto& [grid, own] : grids_of(scene, settings)) {
        const auto is_it = [&, &asked = grid, &how = own](const Grid& one) {
            return one.is(asked, how) && one.is_sent();
        };
        if (std::none_of(grids_.begin(), grids_.end(), is_it) &&
            std::none_of(sending_.begin(), sending_.end(), is_it))
            return false;
    }
    return true;
}

int MediaSet::most_grids() const
{
    return std::min<int>(MAX_GRIDS, (device_.capabilities().max_texture_units - MOST_SAMPLED) / 2);
}

int MediaSet::place(const std::shared_ptr<const VoxelGrid>& grid, const glm::dmat4& world_from_grid,
                    const SceneSettings& settings)
{
    if (grid == nullptr || grid->empty())
        return -1;
    PlacedGrid placed;
    placed.texture = upload(grid, settings);
    const glm::dvec3 origin(grids_[static_cast<std::size_t>(placed.texture)].plan.origin);
    placed.index_from_world = glm::translate(glm::dmat4(1.0), -origin) *
                              glm::inverse(world_from_grid * grid->world_from_index);
    const auto found = std::find(placed_.begin(), placed_.end(), placed);
    if (found != placed_.end())
        return static_cast<int>(found - placed_.begin());
    if (static_cast<int>(placed_.size()) == most_grids())
        throw Error(fmt::format("the scene needs more than {} grids, and this GL ({}) has texture "
                                "units for no more; use fewer media, or merge grids",
                                most_grids(), device_.capabilities().renderer));
    placed_.push_back(placed);
    return static_cast<int>(placed_.size()) - 1;
}

/// What most voxels have at least in all channels, by mean and deviation, 0..1: in eighths, so that
/// a sequence's frames agree.
static float least_of_most(const VoxelGrid& grid)
{
    double count = 0, sum = 0, squares = 0;
    const auto add = [&](const float* v, double voxels) {
        const double least = grid.channels == 1 ? *v : std::min({v[0], v[1], v[2]});
        const double most = grid.channels == 1 ? *v : std::max({v[0], v[1], v[2]});
        if (!(most > 0))
            return;
        count += voxels;
        sum += voxels * least;
        squares += voxels * least * least;
    };
    for (std::size_t i = 0; i < grid.values.size(); i += static_cast<std::size_t>(grid.channels))
        add(grid.values.data() + i, 1);
    for (const VoxelTile& tile : grid.tiles) {
        const glm::dvec3 bricks(tile.brick_max - tile.brick_min + 1);
        add(&tile.value.x, bricks.x * bricks.y * bricks.z * VoxelGrid::kBrickVoxels);
    }
    const double mean = sum / std::max(count, 1.0);
    const double deviation = std::sqrt(std::max(squares / std::max(count, 1.0) - mean * mean, 0.0));
    constexpr double kEighths = 8;
    return static_cast<float>(std::floor(kEighths * std::clamp(mean - deviation, 0.0, 1.0)) /
                              kEighths);
}

void MediaSet::add(const GridMedium& medium, const SceneSettings& settings)
{
    const auto [dims, glows, hot, tinted] = Use(medium);
    if (!dims && !glows && !hot)
        return;
    const glm::dmat4 world_from_grid =
        glm::scale(glm::translate(glm::dmat4(1.0), medium.translate), glm::dvec3(medium.scale));

    Entry entry;
    // A flame that is empty, or not there, must not set the smoke on fire.
    const glm::vec3 emission = glows ? medium.emission_per_unit : glm::vec3(0);
    entry.params =
        coefficients(medium.sigma_s_per_density, medium.sigma_a_per_density, emission, medium.g);
    // A medium that only glows is given its flame for a density, with coefficients of 0.
    if (!dims)
        entry.params = coefficients(glm::vec3(0), glm::vec3(0), emission, 0);
    if (glows)
        entry.emission = place(medium.emission, world_from_grid, settings);
    if (hot) {
        entry.params.blackbody = static_cast<float>(kBlackbodyOfKilokelvin) *
                                 medium.blackbody_intensity * medium.blackbody_tint;
        entry.params.kilokelvin_per_unit = static_cast<float>(kelvin_per_unit(medium) / 1000);
        entry.temperature = place(medium.temperature, world_from_grid, for_temperature(settings));
        if (settings.storage == Storage::automatic) {
            const int texture = placed_[static_cast<std::size_t>(entry.temperature)].texture;
            grids_[static_cast<std::size_t>(texture)].plan.storage_reason =
                "a byte's error would be four times as large in a temperature's light";
        }
    }
    entry.density = dims    ? place(medium.density, world_from_grid, settings)
                    : glows ? entry.emission
                            : entry.temperature;
    if (tinted) {
        entry.tint = place(medium.color, world_from_grid, settings);
        if (entry.tint >= 0 && medium.g > 0)
            entry.least_tint = least_of_most(*medium.color);
    }
    entry.depth = dims ? Depth::marched : Depth::none;

    const auto field_bounds = [&](int placed) {
        const GridLayout& plan = layout_of(placed);
        Bounds field;
        field.add(glm::dvec3(plan.field_min - plan.origin));
        field.add(glm::dvec3(plan.field_max - plan.origin));
        return field;
    };
    entry.bounds_from_world = placed_[static_cast<std::size_t>(entry.density)].index_from_world;
    const auto add_bounds = [&](int placed, const Bounds& bounds) {
        entry.bounds.add(bounds.transformed(
            entry.bounds_from_world *
            glm::inverse(placed_[static_cast<std::size_t>(placed)].index_from_world)));
    };
    if (dims || glows)
        entry.bounds = field_bounds(entry.density);
    if (entry.emission >= 0)  // a flame may reach out of its smoke
        add_bounds(entry.emission, field_bounds(entry.emission));
    if (entry.temperature >= 0)  // but the air around it is of no concern
        for (const OccupiedBox& box :
             occupied_boxes(layout_of(entry.temperature), kMostBoxes, entry.dark()))
            add_bounds(entry.temperature, box.bounds);
    media_.push_back(entry);

    ++traits_.heterogeneous;
    traits_.marched += dims ? 1 : 0;
    traits_.colored_density |= dims && medium.density->channels == 3;
}

void MediaSet::add(const BoxMedium& medium)
{
    if (is_zero(medium.sigma_s + medium.sigma_a) && is_zero(medium.emission))
        return;
    Entry entry;
    entry.params = coefficients(medium.sigma_s, medium.sigma_a, medium.emission, medium.g);
    entry.bounds.add(medium.min);
    entry.bounds.add(medium.max);
    entry.is_box = true;
    std::visit(Overloaded{[&](const HomogeneousProfile&) {
                              entry.profile = Profile::homogeneous;
                              entry.depth = Depth::closed;
                          },
                          [&](const ExpHeightProfile& height) {
                              entry.profile = Profile::exp_height;
                              entry.depth = Depth::closed;
                              entry.height = height.z0;
                              entry.params.inverse_scale_height =
                                  static_cast<float>(1.0 / height.scale_height);
                              ++traits_.heterogeneous;
                          },
                          [&](const NoiseProfile& noise) {
                              entry.profile = Profile::noise;
                              entry.depth = Depth::marched;
                              entry.noise = noise;
                              double amplitudes = 0;
                              for (int i = 0; i < noise.octaves; ++i)
                                  amplitudes += std::pow(noise.gain, i);
                              entry.params.noise_threshold = static_cast<float>(noise.threshold);
                              entry.params.noise_gain = static_cast<float>(noise.gain);
                              entry.params.noise_scale = static_cast<float>(1.0 / amplitudes);
                              entry.params.noise_octaves = noise.octaves;
                              ++traits_.heterogeneous;
                          }},
               medium.profile);
    if (is_zero(medium.sigma_s + medium.sigma_a))
        entry.depth = Depth::none;
    traits_.marched += entry.is_marched() ? 1 : 0;
    media_.push_back(entry);
}

std::shared_ptr<const VoxelGrid> MediaSet::noise_grid(const Entry& box)
{
    const auto same = [&](const NoiseGrid& one) {
        return one.noise == box.noise && one.bounds.min == box.bounds.min &&
               one.bounds.max == box.bounds.max;
    };
    // With the zeros around it, whichever layout is asked for.
    const int longest = device_.capabilities().max_texture_3d - 2;
    const auto old = std::find_if(old_noise_grids_.begin(), old_noise_grids_.end(), same);
    noise_grids_.push_back(
        old != old_noise_grids_.end()
            ? *old
            : NoiseGrid{box.noise, box.bounds, make_noise_grid(box.noise, box.bounds, longest)});
    return noise_grids_.back().grid;
}

void MediaSet::read_noise_from_grids(const SceneSettings& settings)
{
    for (Entry& entry : media_) {
        // One that drifts would need another grid in each frame.
        if (!settings.noise_grid || !entry.is_noise() || entry.noise.drift != glm::dvec3(0))
            continue;
        const bool unit_left = static_cast<int>(placed_.size()) < most_grids();
        const std::shared_ptr<const VoxelGrid> grid = unit_left ? noise_grid(entry) : nullptr;
        if (grid != nullptr)
            entry.density = place(grid, glm::dmat4(1.0), settings);
        else
            device_.log(
                LogLevel::info,
                fmt::format("SceneSettings::noise_grid: the noise of medium {} is worked out "
                            "at each sample, as {}",
                            &entry - media_.data(),
                            unit_left ? "a grid of it would be too large"
                                      : "no texture unit is left for a grid of it"));
    }
}

void MediaSet::clear()
{
    grids_.clear();
    placed_.clear();
    media_.clear();
    occupied_.clear();
    ++occupied_id_;
    noise_grids_.clear();
    small_glows_.reset();
    split_off_.clear();
    carried_glow_.reset();
    traits_ = {};
}

void MediaSet::set(const Scene& scene, const SceneSettings& settings)
{
    old_grids_ = std::move(grids_);
    old_noise_grids_ = std::move(noise_grids_);
    clear();
    time_ = scene.time;
    for (const Medium& medium : scene.media)
        std::visit(Overloaded{[&](const GridMedium& grid) { add(grid, settings); },
                              [&](const BoxMedium& box) { add(box); }},
                   medium);
    read_noise_from_grids(settings);
    old_grids_.clear();
    old_noise_grids_.clear();
    if (media_.size() > MAX_MEDIA)
        throw Error(fmt::format("the scene has {} media, and {} is the most at once; merge some",
                                media_.size(), MAX_MEDIA));

    find_occupied();
    find_islands();
    traits_.media = static_cast<int>(media_.size());
    float g = 0;
    for (Entry& entry : media_) {
        traits_.noise_grids += entry.is_noise() && entry.density >= 0 ? 1 : 0;
        if (entry.is_noise() && entry.density < 0)
            traits_.noise_turns += entry.noise.octaves + 1;
        entry.world_bounds = entry.bounds.transformed(glm::inverse(entry.bounds_from_world));
        traits_.colored_extinction |= !is_grey(glm::vec3(entry.params.sigma_t));
        traits_.blackbody |= entry.temperature >= 0;
        traits_.emission |= entry.glows();
        if (!entry.scatters())
            continue;
        traits_.isotropic &= entry.params.g == 0.0f;
        traits_.mixed_g |= traits_.scatters && entry.params.g != g;
        traits_.scatters = true;
        traits_.most_g = std::max(traits_.most_g, std::abs(entry.params.g));
        g = entry.params.g;
    }
    traits_.g = g;
    find_small();
    // A shader that knows one g alone reads it from the first medium.
    if (!traits_.mixed_g && !media_.empty())
        media_.front().params.g = g;
    traits_.colored_extinction |= traits_.colored_density;
    traits_.bricked_grids = static_cast<int>(std::count_if(
        grids_.begin(), grids_.end(), [](const Grid& g_) { return static_cast<bool>(g_.pages); }));
}

double MediaSet::Entry::detail() const
{
    if (is_noise())
        return noise.feature_size / std::pow(noise.lacunarity, noise.octaves - 1);
    return params.inverse_scale_height > 0 ? 1.0 / params.inverse_scale_height
                                           : std::numeric_limits<double>::infinity();
}

float MediaSet::Entry::thickest() const
{
    const double heights = is_noise() ? 0 : (height - bounds.min.z) * params.inverse_scale_height;
    return static_cast<float>(std::exp(std::min(heights, 40.0)));
}

const GridLayout& MediaSet::layout_of(int placed) const
{
    const PlacedGrid& grid = placed_[static_cast<std::size_t>(placed)];
    return grids_[static_cast<std::size_t>(grid.texture)].plan;
}

double MediaSet::box_detail(const Entry& box) const
{
    // Steps are cut at the faces of a medium that is alone; those of others are detail.
    return media_.size() == 1 ? box.detail() : 0.0;
}

Occupied MediaSet::occupied_by(const Entry& box, float per_unit) const
{
    return {glm::inverse(box.bounds_from_world),
            {{box.bounds, per_unit * box.thickest()}},
            box_detail(box)};
}

Occupied MediaSet::occupied_by(int placed, std::vector<OccupiedBox> boxes, float per_unit) const
{
    for (OccupiedBox& box : boxes)
        box.most *= per_unit;
    const glm::dmat4 world_from_index =
        glm::inverse(placed_[static_cast<std::size_t>(placed)].index_from_world);
    return {world_from_index, std::move(boxes), voxel_of(placed)};
}

double MediaSet::voxel_of(int placed) const
{
    const glm::dmat4 world_from_index =
        glm::inverse(placed_[static_cast<std::size_t>(placed)].index_from_world);
    return std::min({glm::length(world_from_index[0]), glm::length(world_from_index[1]),
                     glm::length(world_from_index[2])});
}

double MediaSet::densest(const Entry& medium) const
{
    const glm::vec3 sigma_t(medium.params.sigma_t);
    double density = 1;
    if (medium.is_box)
        density = double{medium.thickest()};
    else if (medium.density >= 0)
        density = double{grids_[static_cast<std::size_t>(
                                    placed_[static_cast<std::size_t>(medium.density)].texture)]
                             .source->max_value};
    return density * double{std::max({sigma_t.r, sigma_t.g, sigma_t.b})};
}

double MediaSet::grid_detail(const Entry& medium) const
{
    // Where a voxel is thicker than this a part of it hides what is behind, and the medium looks
    // like a surface.
    constexpr double kThick = 2;
    // Flames end sharply, and what glows by Planck's law changes as a high power of a temperature.
    constexpr double kOfFlame = 0.5, kOfGlow = 0.25;
    double least = MediaDetail::kNowhere;
    const auto add = [&](int placed, double share) {
        if (placed >= 0)
            least = std::min(least, share * voxel_of(placed));
    };
    if (medium.density >= 0 && medium.density != medium.temperature) {
        const double most = densest(medium) * voxel_of(medium.density);
        add(medium.density, 1 / std::max(1.0, most / kThick));
    }
    add(medium.tint, 1);
    add(medium.emission, kOfFlame);
    add(medium.temperature, kOfGlow);
    return least;
}

void MediaSet::find_occupied()
{
    constexpr float kGlows = std::numeric_limits<float>::infinity();
    const auto add = [&](int placed, float per_unit, float least = 0) {
        occupied_.push_back(
            occupied_by(placed, occupied_boxes(layout_of(placed), kMostBoxes, least), per_unit));
    };
    for (const Entry& entry : media_) {
        const glm::vec3 sigma_t(entry.params.sigma_t), emission(entry.params.emission);
        const float most = is_zero(emission) || entry.emission >= 0
                               ? std::max({sigma_t.r, sigma_t.g, sigma_t.b})
                               : kGlows;
        if (entry.density >= 0 && entry.density != entry.temperature)
            add(entry.density, most);
        else if (entry.density < 0)
            occupied_.push_back(occupied_by(entry, most));
        if (entry.is_box)
            occupied_.back().detail = box_detail(entry);
        if (entry.emission >= 0)
            add(entry.emission, kGlows);
        if (entry.temperature >= 0)
            add(entry.temperature, kGlows, entry.dark());
    }
}

void MediaSet::find_islands()
{
    std::size_t left = MAX_ISLANDS;
    for (Entry& entry : media_) {
        if (entry.is_box || layout_of(entry.density).tree.levels == 0)
            continue;
        std::vector<OccupiedBox> boxes;
        for (const int placed : {entry.density, entry.emission, entry.temperature}) {
            if (placed < 0)
                continue;
            const glm::dmat4 bounds_from_grid =
                entry.bounds_from_world *
                glm::inverse(placed_[static_cast<std::size_t>(placed)].index_from_world);
            for (OccupiedBox box : occupied_boxes(
                     layout_of(placed), kMostBoxes,
                     placed == entry.temperature && placed != entry.density ? entry.dark() : 0)) {
                box.bounds = box.bounds.transformed(bounds_from_grid);
                boxes.push_back(box);
            }
        }
        entry.islands = islands(boxes, left);
        if (entry.islands.size() < 2)
            entry.islands.clear();
        constexpr std::size_t kFewLeaves = 64;  // one tile has 26: its faces, edges and corners
        entry.tiles =
            entry.islands.empty() && layout_of(entry.density).tree.leaves.size() <= kFewLeaves;
        left -= entry.islands.size();
        traits_.islands += static_cast<int>(entry.islands.size());
    }
}

void MediaSet::find_small()
{
    constexpr double kSmall = 0.25;  // of an edge of all
    // A sheet that is as long as all of them is small too, where they are no sheet.
    const auto edges = [](const Bounds& box) {
        const glm::dvec3 size = box.max - box.min;
        return glm::dvec2(std::max({size.x, size.y, size.z}), std::min({size.x, size.y, size.z}));
    };
    const glm::dvec2 of_all = edges(bounds());
    int parts = traits_.islands;
    for (Entry& entry : media_) {
        entry.is_small = entry.islands.empty() && parts < MAX_ISLANDS &&
                         glm::any(glm::lessThanEqual(edges(entry.world_bounds), kSmall * of_all));
        parts += entry.is_small ? 1 : 0;
    }
}

MediaDetail MediaSet::detail() const
{
    MediaDetail out;
    for (const Entry& entry : media_) {
        out.has_outline |= entry.is_box;
        if (entry.is_box)
            out.boxes = std::min(out.boxes, box_detail(entry));
        else
            out.grids = std::min(out.grids, grid_detail(entry));
    }
    return out;
}

Bounds MediaSet::bounds() const
{
    Bounds all;
    for (const Entry& entry : media_)
        all.add(entry.world_bounds);
    return all;
}

Bounds MediaSet::ends() const
{
    constexpr double kFarOff = 1e30;
    constexpr double kThin = 0.2;  // of the thickest: haze around smoke
    double most = 0;
    for (const Entry& entry : media_)
        most = std::max(most, densest(entry));
    const Bounds all = bounds();
    Bounds ends{glm::dvec3(-kFarOff), glm::dvec3(kFarOff)};
    for (const Entry& entry : media_)
        for (int i = 0; i < 3 && entry.is_box && densest(entry) > kThin * most; ++i) {
            if (entry.world_bounds.min[i] == all.min[i])
                ends.min[i] = all.min[i];
            if (entry.world_bounds.max[i] == all.max[i])
                ends.max[i] = all.max[i];
        }
    return ends;
}

VoxelFrame MediaSet::voxel_frame() const
{
    VoxelFrame frame;
    double most = 0;
    for (const Entry& entry : media_) {
        if (!entry.is_marched())
            continue;
        double cells = 1;  // per unit of the medium's own space
        if (entry.is_noise())
            cells = std::pow(entry.noise.lacunarity, entry.noise.octaves - 1) /
                    entry.noise.feature_size;
        const glm::dvec3 size = entry.bounds.max - entry.bounds.min;
        if (entry.tiles)
            cells = 64 / std::max({size.x, size.y, size.z});
        const glm::dvec3 extent = size * cells;
        const double voxels = extent.x * extent.y * extent.z;
        if (voxels <= most)
            continue;
        most = voxels;
        frame.tiles = entry.tiles;
        frame.voxel_from_world =
            glm::scale(glm::dmat4(1.0), glm::dvec3(cells)) * entry.bounds_from_world;
    }
    if (most == 0) {
        const glm::dvec3 extent = glm::max(bounds().max - bounds().min, glm::dvec3(1e-12));
        frame.voxel_from_world = glm::scale(glm::dmat4(1.0), 96.0 / extent);
    }
    for (const Entry& entry : media_) {
        const Bounds voxels = entry.bounds.transformed(frame.voxel_from_world *
                                                       glm::inverse(entry.bounds_from_world));
        if (entry.is_marched())
            frame.marched.add(voxels);
        if (entry.scatters())
            frame.scattering.add(voxels);
    }
    return frame;
}

std::vector<VoxelFrame> MediaSet::island_frames() const
{
    constexpr double kSlack = 0.5;  // voxels
    std::vector<VoxelFrame> frames;
    const auto holds = [](const VoxelFrame& frame, const Bounds& world) {
        const Bounds inside = world.transformed(frame.voxel_from_world);
        return glm::all(glm::greaterThanEqual(inside.min, frame.marched.min - kSlack)) &&
               glm::all(glm::lessThanEqual(inside.max, frame.marched.max + kSlack));
    };
    for (const Entry& entry : media_)
        for (const Bounds& island : entry.islands) {
            const Bounds world = island.transformed(glm::inverse(entry.bounds_from_world));
            if (std::none_of(frames.begin(), frames.end(),
                             [&](const VoxelFrame& frame) { return holds(frame, world); }))
                frames.push_back({entry.bounds_from_world, island, island});
        }
    return frames;
}

std::optional<glm::vec3> MediaSet::extinction_color() const
{
    if (traits_.colored_density)
        return std::nullopt;
    std::optional<glm::vec3> color;
    for (const Entry& entry : media_) {
        const glm::vec3 sigma_t(entry.params.sigma_t);
        const float most = std::max({sigma_t.r, sigma_t.g, sigma_t.b});
        if (most == 0)
            continue;
        const glm::vec3 own = sigma_t / most;
        if (color && glm::any(glm::greaterThan(glm::abs(own - *color), glm::vec3(1e-5f))))
            return std::nullopt;
        color = own;
    }
    return color;
}

std::optional<glm::vec3> MediaSet::marched_color() const
{
    std::optional<glm::vec3> color;
    for (const Entry& entry : media_) {
        if (!entry.is_marched())
            continue;
        const glm::vec3 own = glm::vec3(entry.params.sigma_t) / entry.params.sigma_t.a;
        if (traits_.colored_density ||
            (color && glm::any(glm::greaterThan(glm::abs(own - *color), glm::vec3(1e-5f)))))
            return std::nullopt;
        color = own;
    }
    return color;
}

glm::vec3 MediaSet::mean_albedo() const
{
    glm::vec3 sigma_s(0), sigma_t(1e-20f);
    for (const Entry& entry : media_) {
        sigma_s += entry.params.sigma_s;
        sigma_t += glm::vec3(entry.params.sigma_t);
    }
    return glm::min(sigma_s / sigma_t, glm::vec3(1));
}

std::vector<Extinction> MediaSet::extinction() const
{
    std::vector<Extinction> all;
    for (const Entry& entry : media_) {
        if (is_zero(glm::vec3(entry.params.sigma_t)))
            continue;
        Extinction one;
        one.sigma_t = glm::vec3(entry.params.sigma_t);
        one.marched = entry.is_marched();
        glm::dmat4 world_from_field(1.0);
        Bounds pinned{glm::dvec3(0), glm::dvec3(1024)};  // voxels: about as many as a grid has
        if (entry.density >= 0) {
            const PlacedGrid& placed = placed_[static_cast<std::size_t>(entry.density)];
            const Grid& grid = grids_[static_cast<std::size_t>(placed.texture)];
            one.grid = grid.source;
            one.layout = grid.asked_layout;
            one.storage = grid.asked_storage;
            world_from_field = glm::inverse(placed.index_from_world);
        }
        if (entry.is_box) {
            pinned = entry.bounds;
            world_from_field = glm::inverse(entry.bounds_from_world);
        }
        one.profile = entry.profile;
        switch (entry.profile) {
        case Profile::grid:
        case Profile::homogeneous:
            one.place[4] = glm::dvec3(world_from_field * glm::dvec4(pinned.min, 1.0));
            break;
        case Profile::exp_height:  // only height counts
            one.per_height = entry.params.inverse_scale_height;
            one.place[4] = glm::dvec3(glm::dvec2(pinned.min), entry.height);
            break;
        case Profile::noise:
            one.noise = entry.noise;
            one.noise.drift = glm::dvec3(0);
            one.place[4] = time_ * entry.noise.drift;
            break;
        }
        constexpr std::array kCorners{0, 1, 2, 4};
        for (std::size_t i = 0; i < kCorners.size(); ++i)
            one.place.at(i) =
                glm::dvec3(world_from_field * glm::dvec4(pinned.corner(kCorners.at(i)), 1.0));
        all.push_back(std::move(one));
    }
    return all;
}

bool is_same_place(glm::dvec3 a, glm::dvec3 b, double tolerance)
{
    constexpr double kRounding = 1e-14;  // of a few operations in double
    return glm::length(a - b) <= tolerance + kRounding * std::max(glm::length(a), glm::length(b));
}

bool is_moved(const Extinction& then, const Extinction& now, glm::dvec3 moved, double tolerance)
{
    if (then.grid != now.grid || then.layout != now.layout || then.storage != now.storage ||
        then.profile != now.profile || then.noise != now.noise ||
        then.per_height != now.per_height || then.marched != now.marched)
        return false;
    constexpr float kSame = 1e-6f;  // a sum of sigma_s and sigma_a rounds
    for (int c = 0; c < 3; ++c)
        if (std::abs(then.sigma_t[c] - now.sigma_t[c]) > kSame * std::abs(then.sigma_t[c]))
            return false;
    for (std::size_t i = 0; i < then.place.size(); ++i)
        if (!is_same_place(then.place.at(i) + moved, now.place.at(i), tolerance))
            return false;
    return true;
}

bool are_moved(const std::vector<Extinction>& then, const std::vector<Extinction>& now,
               glm::dvec3 moved, double tolerance)
{
    return std::equal(
        then.begin(), then.end(), now.begin(), now.end(),
        [&](const Extinction& a, const Extinction& b) { return is_moved(a, b, moved, tolerance); });
}

/// Optical depth of what lies in `around` (metres, world), from side to side, of the mean over it.
static double mean_depth(const Occupied& occupied, const Bounds& around)
{
    double sigma_t_volume = 0;
    const double scale = std::abs(glm::determinant(glm::dmat3(occupied.world_from_box)));
    for (const OccupiedBox& box : occupied.boxes) {
        const glm::dvec3 extent = box.bounds.max - box.bounds.min;
        const glm::dvec3 middle(occupied.world_from_box *
                                glm::dvec4(0.5 * (box.bounds.min + box.bounds.max), 1.0));
        if (glm::any(glm::lessThan(middle, around.min)) ||
            glm::any(glm::greaterThan(middle, around.max)))
            continue;
        sigma_t_volume += static_cast<double>(box.most) * scale * extent.x * extent.y * extent.z;
    }
    const glm::dvec3 extent = glm::max(around.max - around.min, glm::dvec3(1e-12));
    const double volume = extent.x * extent.y * extent.z;
    return sigma_t_volume * (extent.x + extent.y + extent.z) / (3 * volume);
}

std::vector<Occupied> MediaSet::kept_boxes() const
{
    std::vector<Occupied> all;
    for (const Entry& entry : media_) {
        const float per_unit = entry.params.sigma_t.a;
        all.push_back(entry.density < 0
                          ? occupied_by(entry, per_unit)
                          : occupied_by(entry.density,
                                        medium::kept_boxes(layout_of(entry.density), kMostBoxes),
                                        per_unit));
    }
    return all;
}

double MediaSet::mean_optical_depth(const Bounds* part) const
{
    double tau = 0;
    for (const Occupied& occupied : kept_boxes())
        tau += mean_depth(occupied, part != nullptr ? *part : bounds());
    return tau;
}

std::vector<MediaSet::Thickness> MediaSet::thicknesses(const Bounds* part) const
{
    const Bounds within = part != nullptr ? *part : bounds();
    std::vector<Thickness> all{{mean_optical_depth(part), mean_albedo(), within}};
    if (media_.size() < 2)
        return all;
    const std::vector<Occupied> boxes = kept_boxes();
    for (std::size_t i = 0; i < media_.size(); ++i) {
        const Entry& entry = media_[i];
        if (!entry.world_bounds.meets(within))
            continue;
        const Bounds own = entry.world_bounds.common(within);
        const glm::vec3 sigma_t = glm::max(glm::vec3(entry.params.sigma_t), glm::vec3(1e-20f));
        all.push_back({mean_depth(boxes[i], own),
                       glm::min(entry.params.sigma_s / sigma_t, glm::vec3(1)), own});
    }
    return all;
}

double MediaSet::voxel_optical_depth(const VoxelFrame& frame) const
{
    const std::vector<Occupied> boxes = kept_boxes();
    double all = 0, weighed = 0;
    for (std::size_t i = 0; i < media_.size(); ++i) {
        if (!media_[i].is_marched())
            continue;
        const double scale = std::abs(glm::determinant(glm::dmat3(boxes[i].world_from_box)));
        for (const OccupiedBox& box : boxes[i].boxes) {
            const glm::dvec3 extent = box.bounds.max - box.bounds.min;
            const double sigma_t = box.most;
            const double held = sigma_t * scale * extent.x * extent.y * extent.z;
            all += held;
            weighed += held * sigma_t;
        }
    }
    const double edge =
        std::cbrt(std::abs(glm::determinant(glm::inverse(glm::dmat3(frame.voxel_from_world)))));
    return all > 0 ? weighed / all * edge : 0;
}

float MediaSet::Entry::straight_on() const
{
    const float g = std::max(params.g, 0.0f);
    const float least =
        least_tint * std::min({params.sigma_s.r, params.sigma_s.g, params.sigma_s.b});
    return g * g * g * g * std::min(least / std::max(params.sigma_t.a, 1e-20f), 1.0f);
}

MediaSet::StraightOn MediaSet::straight_on_by_depth() const
{
    constexpr double kThin = 0.2;  // optical depth: what is taken for none of it is hardly seen
    StraightOn out;
    if (traits_.most_g <= 0)
        return out;
    std::optional<float> marched;
    float most = 0;
    const std::vector<Occupied> boxes = kept_boxes();
    for (std::size_t i = 0; i < media_.size(); ++i) {
        const Entry& entry = media_[i];
        if (mean_depth(boxes[i], entry.world_bounds) < kThin)
            continue;
        const float straight_on = entry.straight_on();
        if (entry.is_marched())
            marched = std::min(marched.value_or(1.0f), straight_on);
        else
            out.closed = std::max(out.closed, straight_on);
        if (straight_on > most) {
            most = straight_on;
            out.g = entry.params.g;
        }
    }
    out.marched = marched.value_or(0.0f);
    return out;
}

float MediaSet::straight_on() const
{
    const StraightOn by_depth = straight_on_by_depth();
    return std::max(by_depth.closed, by_depth.marched);
}

void MediaSet::split_forward_peaks(bool split)
{
    for (Entry& entry : media_)
        entry.params.light_dimming = split && !entry.is_marched() ? 1 - entry.straight_on() : 1;
    const StraightOn by_depth = split ? straight_on_by_depth() : StraightOn{};
    marched_light_dimming_ = 1 - by_depth.marched;
    peak_g_ = split ? std::optional(by_depth.g) : std::nullopt;
    const float most = std::max(by_depth.closed, by_depth.marched);
    peak_straight_ = most / std::max(1 - most, 1e-6f);
}

gl::Defines MediaSet::defines() const
{
    std::vector<GridSource> grids;
    for (std::size_t k = 0; k < placed_.size(); ++k) {
        const GridLayout& plan = layout_of(static_cast<int>(k));
        grids.push_back({plan.layout == Layout::dense ? Kind::dense
                         : plan.tree.levels > 0       ? Kind::tree
                                                      : Kind::bricks,
                         plan.channels == 4});
    }
    std::vector<MediumSource> media;
    for (const Entry& entry : media_)
        media.push_back({entry.profile, entry.depth, entry.is_box, !entry.islands.empty(),
                         entry.density, !is_zero(entry.params.emission), entry.emission, entry.tint,
                         entry.temperature});
    gl::Defines defines{{"extinction_t", traits_.colored_extinction ? "vec3" : "float"},
                        {"kGridCount", fmt::format("{}", placed_.size())},
                        {"kMediumCount", fmt::format("{}", media_.size())}};
    const auto add = [&](bool condition, const char* name) {
        if (condition)
            defines.emplace_back(name, "");
    };
    add(traits_.emission, "kEmission");
    add(traits_.mixed_g, "kMixedG");
    add(traits_.isotropic, "kIsotropic");
    add(traits_.islands > 0, "kIslands");
    const bool has_small = std::any_of(media_.begin(), media_.end(),
                                       [](const Entry& entry) { return entry.is_small; });
    add(traits_.islands > 0 || has_small, "kPartSteps");
    defines.add_file("written/media.glsl", write_media(grids, media, traits_.colored_extinction));
    return defines;
}

bool MediaSet::marched_alone() const
{
    return std::all_of(media_.begin(), media_.end(),
                       [](const Entry& entry) { return entry.is_marched() || !entry.scatters(); });
}

glm::dvec3 MediaSet::base_voxel(int placed, glm::dvec3 eye) const
{
    if (placed < 0 || layout_of(placed).tree.levels == 0)
        return glm::dvec3(0);
    constexpr double kPages = 1 << 28;  // past them no grid has any
    const glm::dvec3 eye_voxel(placed_[static_cast<std::size_t>(placed)].index_from_world *
                               glm::dvec4(eye, 1.0));
    return double{VoxelGrid::kBrickDim} *
           glm::clamp(glm::floor(eye_voxel / double{VoxelGrid::kBrickDim}), -kPages, kPages);
}

const VoxelGrid& MediaSet::grid_of(int placed) const
{
    const int texture = placed_[static_cast<std::size_t>(placed)].texture;
    return *grids_[static_cast<std::size_t>(texture)].source;
}

Bounds MediaSet::glow_bounds(const Entry& medium) const
{
    Bounds bounds;
    const auto add = [&](int placed, float least) {
        const glm::dmat4 world_from_index =
            glm::inverse(placed_[static_cast<std::size_t>(placed)].index_from_world);
        for (const OccupiedBox& box : occupied_boxes(layout_of(placed), kMostBoxes, least))
            bounds.add(box.bounds.transformed(world_from_index));
    };
    if (medium.is_box)
        bounds = medium.world_bounds;
    if (!medium.is_box && medium.emission >= 0)
        add(medium.emission, 0);
    if (medium.temperature >= 0)
        add(medium.temperature, medium.dark());
    return bounds;
}

/// A grid where a medium has placed it, read by places of the world.
class MediaSet::WorldLookup {
public:
    WorldLookup(const MediaSet& media, int placed)
        : lookup_(media.grid_of(placed)), is_scalar_(media.grid_of(placed).channels == 1)
    {
        const glm::dvec3 first(media.layout_of(placed).origin);
        index_from_world_ = glm::translate(glm::dmat4(1.0), first) *
                            media.placed_[static_cast<std::size_t>(placed)].index_from_world;
    }
    [[nodiscard]] const glm::dmat4& index_from_world() const { return index_from_world_; }
    /// A scalar in all three channels.
    [[nodiscard]] glm::dvec3 at(glm::dvec3 place) const
    {
        const glm::dvec3 value = lookup_.sample(index_from_world_ * glm::dvec4(place, 1.0));
        return is_scalar_ ? glm::dvec3(value.x) : value;
    }

private:
    VoxelLookup lookup_;
    bool is_scalar_;
    glm::dmat4 index_from_world_{1.0};
};

std::vector<MediaSet::GlowingGrid> MediaSet::glowing_grids(const Entry& medium) const
{
    const glm::dvec3 emission(medium.params.emission);
    const auto flame = [emission](glm::dvec3 value) { return emission * value; };
    std::vector<GlowingGrid> grids;
    if (medium.is_box)
        grids.push_back({medium.density, flame});
    else if (medium.emission >= 0)
        grids.push_back({medium.emission, flame});
    if (!medium.is_box && medium.temperature >= 0)
        grids.push_back({medium.temperature, [params = medium.params](glm::dvec3 value) {
                             const auto kilokelvin = static_cast<float>(value.x);
                             return glm::dvec3(
                                 params.blackbody *
                                 shared::blackbody(params.kilokelvin_per_unit * kilokelvin));
                         }});
    return grids;
}

Glow MediaSet::glow_of_entry(const Entry& medium) const
{
    const glm::dvec3 emission(medium.params.emission), sigma_t(glm::vec3(medium.params.sigma_t));
    if (medium.is_box && medium.density < 0)
        return glow_of(medium.bounds, emission, sigma_t,
                       [&](double z) { return medium.at_height(z); });
    // Where a medium only glows its flame is its density too, of coefficients of 0.
    std::optional<WorldLookup> density;
    if (sigma_t != glm::dvec3(0))
        density.emplace(*this, medium.density);
    Glow all;
    for (const GlowingGrid& glowing : glowing_grids(medium)) {
        const glm::dmat4 world_from_index =
            glm::inverse(WorldLookup(*this, glowing.placed).index_from_world());
        std::function<glm::dvec3(glm::dvec3)> extinction;
        if (density)
            extinction = [&](glm::dvec3 at) {
                return sigma_t * density->at(world_from_index * glm::dvec4(at, 1.0));
            };
        all = together(all, glow_of(grid_of(glowing.placed), glowing.radiance, extinction)
                                .transformed(world_from_index));
    }
    return all;
}

GlowCells MediaSet::glow_cells_of(const Entry& medium, const Bounds& bounds) const
{
    const glm::dvec3 emission(medium.params.emission), sigma_t(glm::vec3(medium.params.sigma_t));
    if (sigma_t == glm::dvec3(0))
        return {};
    if (medium.is_box && medium.density < 0) {
        const auto there = [&](glm::dvec3 place) {
            const glm::dvec3 at(medium.bounds_from_world * glm::dvec4(place, 1.0));
            const bool inside = glm::all(glm::greaterThanEqual(at, medium.bounds.min)) &&
                                glm::all(glm::lessThanEqual(at, medium.bounds.max));
            return inside ? medium.at_height(at.z) : 0.0;
        };
        return glow_cells(
            bounds, [&](glm::dvec3 place) { return emission * there(place); },
            [&](glm::dvec3 place) { return sigma_t * there(place); });
    }
    const WorldLookup density(*this, medium.density);
    std::vector<std::pair<WorldLookup, std::function<glm::dvec3(glm::dvec3)>>> grids;
    for (const GlowingGrid& glowing : glowing_grids(medium))
        grids.emplace_back(WorldLookup(*this, glowing.placed), glowing.radiance);
    const auto radiance = [&](glm::dvec3 place) {
        glm::dvec3 sum(0);
        for (const auto& [grid, of_value] : grids)
            sum += of_value(grid.at(place));
        return sum;
    };
    return glow_cells(bounds, radiance,
                      [&](glm::dvec3 place) { return sigma_t * density.at(place); });
}

const std::vector<std::optional<SmallGlow>>& MediaSet::small_glows(double most)
{
    if (small_glows_ && small_glows_->first == most)
        return small_glows_->second;
    // A flame's faint rim counts for little.
    constexpr double kRim = 2;
    std::vector<std::optional<SmallGlow>> glows;
    for (const Entry& medium : media_) {
        std::optional<SmallGlow>& small = glows.emplace_back();
        const bool evaluated = medium.is_noise() && medium.density < 0;
        if (!medium.glows() || evaluated || most == 0)
            continue;
        const Bounds bounds = glow_bounds(medium);
        const glm::dvec3 size = bounds.max - bounds.min;
        if (bounds.empty() || std::max({size.x, size.y, size.z}) / kRim > most)
            continue;
        const Glow glow = glow_of_entry(medium);
        if (glow.power != glm::dvec3(0) && glow.axes().edges.x <= most)
            small = {glow, glow_cells_of(medium, bounds)};
    }
    return small_glows_.emplace(most, std::move(glows)).second;
}

bool MediaSet::carries_glow() const
{
    for (std::size_t m = 0; m < media_.size(); ++m)
        if (media_[m].glows() && (m >= split_off_.size() || !split_off_[m]))
            return true;
    return false;
}

const MediaSet::CarriedGlow& MediaSet::carried_glow()
{
    if (carried_glow_)
        return *carried_glow_;
    carried_glow_.emplace();
    for (std::size_t m = 0; m < media_.size(); ++m) {
        const bool is_light = m < split_off_.size() && split_off_[m];
        const Bounds bounds = media_[m].glows() && !is_light ? glow_bounds(media_[m]) : Bounds();
        if (bounds.empty())
            continue;
        carried_glow_->bounds.add(bounds);
        carried_glow_->glow = together(carried_glow_->glow, glow_of_entry(media_[m]));
    }
    return *carried_glow_;
}

void MediaSet::bind(glm::dvec3 eye, bool carried)
{
    const glm::dmat4 world_from_eye = glm::translate(glm::dmat4(1.0), eye);
    shared::MediaParams params{};
    params.marched_light_dimming = marched_light_dimming_;
    params.peak_g = peak_g_.value_or(0.0f);
    params.peak_straight = peak_straight_;
    for (std::size_t k = 0; k < placed_.size(); ++k) {
        const Grid& grid = grids_[static_cast<std::size_t>(placed_[k].texture)];
        shared::GridParams& out = params.grids[k];
        const glm::dvec3 base = base_voxel(static_cast<int>(k), eye);
        out.index_from_world = glm::mat4(glm::translate(glm::dmat4(1.0), -base) *
                                         placed_[k].index_from_world * world_from_eye);
        out.tree =
            glm::ivec4(glm::ivec3(base / double{VoxelGrid::kBrickDim}), grid.plan.tree.levels);
        out.inverse_size = 1.0f / glm::vec3(grid.plan.texture_size);
        out.unit = grid.plan.value_scale;
        out.pages = glm::vec4(glm::vec3(grid.plan.page_count), 0.0f);
        const auto unit = static_cast<GLuint>(GRID_UNIT + k);
        grid.texels.bind(unit);
        grid.pages.bind(unit + static_cast<GLuint>(placed_.size()));
    }
    for (std::size_t m = 0; m < media_.size(); ++m) {
        const Entry& entry = media_[m];
        shared::MediumParams& out = params.media[m];
        out = entry.params;
        if (carried && m < split_off_.size() && split_off_[m])
            out.emission = out.blackbody = glm::vec3(0);
        out.bounds_from_world = glm::mat4(entry.bounds_from_world * world_from_eye);
        glm::dvec3 low = entry.bounds.min, high = entry.bounds.max;
        if (const glm::dvec3 base = base_voxel(entry.density, eye); base != glm::dvec3(0)) {
            out.bounds_from_world = glm::mat4(glm::translate(glm::dmat4(1.0), -base) *
                                              entry.bounds_from_world * world_from_eye);
            low -= base;
            high -= base;
        }
        for (const Bounds& island : entry.islands) {
            const glm::dvec3 base = base_voxel(entry.density, eye);
            params.islands[params.island_count++] = {
                glm::vec3(island.min - base), static_cast<int>(m), glm::vec3(island.max - base)};
        }
        if (entry.is_box) {
            // A box has no scale of its own: subtract the eye in double, not through the matrix.
            out.bounds_from_world = glm::mat4(1.0f);
            low -= eye;
            high -= eye;
        }
        out.bounds_min = glm::vec3(low);
        out.bounds_max = glm::vec3(high);
        if (entry.is_small)
            params.islands[params.island_count++] = {out.bounds_min, static_cast<int>(m),
                                                     out.bounds_max};
        if (entry.is_noise() && entry.density < 0) {
            double frequency = 1.0 / entry.noise.feature_size;
            for (int i = 0; i < entry.noise.octaves; ++i) {
                const glm::dvec3 q = (eye - time_ * entry.noise.drift) * frequency;
                const glm::dvec3 whole = glm::floor(q);
                shared::NoiseOctave& octave = params.octaves[m * MAX_OCTAVES + i];
                octave.cell_offset = {static_cast<int>(std::fmod(whole.x, 2147483648.0)),
                                      static_cast<int>(std::fmod(whole.y, 2147483648.0)),
                                      static_cast<int>(std::fmod(whole.z, 2147483648.0)),
                                      static_cast<int>(noise_octave_seed(entry.noise.seed, i))};
                octave.fraction = glm::vec3(q - whole);
                octave.frequency = static_cast<float>(frequency);
                frequency *= entry.noise.lacunarity;
            }
        } else if (entry.profile == Profile::exp_height) {
            out.base_height = static_cast<float>(entry.height - eye.z);
        }
    }
    block_.write(params);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, MEDIA_BLOCK, block_.id());
}

std::vector<std::string> MediaSet::describe() const
{
    std::vector<std::string> lines;
    for (const Grid& grid : grids_) {
        const GridLayout& plan = grid.plan;
        const auto bytes = plan.gpu_bytes();
        lines.push_back(fmt::format(
            "grid '{}': {} of {} x {} x {} texels in {}{} ({}), {:.2f} MB, {:.2f} bytes an active "
            "voxel",
            grid.source->name,
            plan.layout == Layout::dense ? "one dense texture"
            : plan.tree.levels > 0       ? "bricks in an atlas, found through a tree,"
                                         : "bricks in an atlas",
            plan.texture_size.x, plan.texture_size.y, plan.texture_size.z,
            plan.channels == 4 ? "4 x " : "", storage_name(plan.storage), plan.storage_reason,
            static_cast<double>(bytes) * 1e-6,
            static_cast<double>(bytes) /
                static_cast<double>(std::max<std::uint64_t>(grid.source->active_voxels, 1))));
    }
    return lines;
}

}  // namespace fumarole::medium
