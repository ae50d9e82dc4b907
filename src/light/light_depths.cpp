#include "light/light_depths.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>

#include "gl/stopwatch.h"
#include "light/light_source.h"

namespace fumarole::light {

namespace {

/// The nodes of `auto`: no closer than so many voxels, and no more of them along an axis.
struct AutoNodes {
    double spacing;
    int most;
};

/// Two a voxel where these are thick, since exp of an optical depth bends between them, and down to
/// one where they are thin and many. In a smoke of 51 voxels, whose optical depth is 0.8 each, 76
/// nodes err by a relMSE of 6e-6 to 1e-5, where 96 do by 4e-6, and light comes sooner. 96 of them
/// go along the longest edge, and up to twice as many where much would lie between two: shadows in
/// a plume of 200 voxels of 0.2 each err by 8e-5 with 64, 3e-5 with 96, 2e-5 with 128 (16 steps
/// marched at each sample by 9e-5), and a cloud of an optical depth of 100 is 5 % too dark with 96.
AutoNodes auto_nodes(const medium::VoxelFrame& frame, double voxel_depth)
{
    constexpr double kClose = 0.5, kWide = 1;  // voxels from node to node
    constexpr double kOfRoot = 0.6;            // the error goes as its square by the depth's root
    constexpr double kFewNodes = 64;           // with so many there is little to be saved
    constexpr double kBetween = 0.75;          // optical depth from node to node
    constexpr int kEnough = 96, kMost = 192;
    const glm::dvec3 voxels = frame.marched.max - frame.marched.min;
    const double longest = std::max({voxels.x, voxels.y, voxels.z});
    const double wide = std::min(kOfRoot / std::sqrt(std::max(voxel_depth, 1e-9)), kWide);
    return {std::max(std::min(wide, longest / kFewNodes), kClose),
            static_cast<int>(
                std::clamp(longest * voxel_depth / kBetween, double{kEnough}, double{kMost}))};
}
constexpr double kSamplesPerVoxel = 1;     ///< samples per voxel of the media, down a sun's columns
constexpr double kMostColumnSamples = 16;  ///< most samples from node to node of a column

/// What the texture of depths has along each axis: the columns of a sun that stands askew reach two
/// nodes beyond the lattice on either side before they are there again, and the first of them is
/// there twice.
constexpr int kBeyondLattice = 4;

/// A light's place as it is from `origin`, where it has one.
LightPosition position_from(glm::dvec3 origin, LightPosition position)
{
    if (!position.far)
        position.at -= origin;
    return position;
}

}  // namespace

bool LightDepths::is_moved(const Key& then, const Key& now)
{
    return light::is_moved(then.lattice, now.lattice) && then.colored == now.colored &&
           medium::are_moved(then.media, now.media, now.lattice.origin - then.lattice.origin,
                             tolerance_of(now.lattice));
}

bool LightDepths::is_same(const LightPosition& a, const LightPosition& b) const
{
    const LatticePlace& lattice = key_.lattice;
    const double nodes = std::max({lattice.count.x, lattice.count.y, lattice.count.z});
    return a.far == b.far &&
           (a.far ? glm::length(a.at - b.at) <= kSameNode / nodes
                  : medium::is_same_place(
                        a.at, b.at, tolerance_of(lattice) + 1e-14 * glm::length(lattice.origin)));
}

void LightDepths::set(const SceneSettings& settings, const medium::VoxelFrame& frame,
                      medium::MediaSet& media, LightSet& lights)
{
    refill_frames_ = settings.shadow_fill;
    const bool same = set_lattice(settings, frame, media, lights.count());
    fill_defines_ = extinction_.fill_defines(media, write_lights({}));
    wanted_.clear();
    for (const LightPosition& light : lights.points())
        wanted_.push_back(position_from(place_of(lattice_).origin, light));
    const Matches matches = match_lights(same);
    const gl::Stopwatch watch(tools_.device, tools_.timers);
    if (matches.placed && !extinction_)
        extinction_.fill(frame, media, lights);
    if (matches.in_place && (refill_ || matches.all))
        return;  // what is on its way begins anew where lights have moved meanwhile
    refill_.reset();
    if (matches.in_place && refill_frames_ > 1) {
        begin_refill();
        return;
    }
    fill_missing(matches, media, lights);
    ms_ = watch.ms();
}

void LightDepths::clear()
{
    refill_.reset();
    drop();
}

void LightDepths::drop()
{
    depths_ = {};
    packed_depths_ = {};
    packed_ = false;
    lights_.clear();
}

bool LightDepths::set_lattice(const SceneSettings& settings, const medium::VoxelFrame& frame,
                              const medium::MediaSet& media, int lights)
{
    AutoNodes nodes{1e-9, settings.shadow_volume_size};
    if (settings.shadow_volume_size == kAutomatic)
        nodes = auto_nodes(frame, media.voxel_optical_depth(frame));
    const int most = std::min(
        nodes.most,
        std::max(tools_.device.capabilities().max_texture_3d / lights - kBeyondLattice, 2));
    const Lattice lattice =
        make_lattice(frame.voxel_from_world, frame.marched, nodes.spacing, most);
    Key key{media.extinction(), place_of(lattice), extinction_.is_colored()};
    std::erase_if(key.media, [](const medium::Extinction& medium) { return !medium.marched; });
    if (!key.colored)  // the mean is what is stored, of one colour for all
        for (medium::Extinction& medium : key.media)
            medium.sigma_t = glm::vec3(glm::dot(medium.sigma_t, glm::vec3(1.0f / 3.0f)));
    const bool same = depths_ && is_moved(key_, key);
    if (!same || refill_frames_ == 1) {
        refill_.reset();
        extinction_.drop();
    }
    if (!same) {
        drop();
        key_ = std::move(key);
    }
    // What was filled moves with the media: only where it lies is new.
    lattice_ = lattice;
    voxels_from_node_ = glm::dmat3(frame.voxel_from_world * glm::inverse(lattice.node_from_world));
    if (extinction_)
        extinction_.move_to(frame);
    return same;
}

LightDepths::Matches LightDepths::match_lights(bool same) const
{
    // A light that has come or gone moves the others to other layers.
    Matches matches;
    matches.in_place = same && lights_.size() == wanted_.size();
    for (std::size_t i = 0; i < wanted_.size(); ++i) {
        const auto is_wanted = [&](const LightPosition& light) {
            return is_same(light, wanted_[i]);
        };
        auto at = std::find_if(lights_.begin(), lights_.end(), is_wanted);
        if (i < lights_.size() && is_wanted(lights_[i]))
            at = lights_.begin() + static_cast<std::ptrdiff_t>(i);
        const int layer = at == lights_.end() ? -1 : static_cast<int>(at - lights_.begin());
        matches.layers.push_back(layer);
        matches.all &= layer >= 0;
        matches.in_place &= layer < 0 || layer == static_cast<int>(i);
        matches.placed |= layer < 0 && !wanted_[i].far;
    }
    return matches;
}

void LightDepths::fill_missing(const Matches& matches, medium::MediaSet& media, LightSet& lights)
{
    const int count = static_cast<int>(wanted_.size());
    const auto layer_of = [&](int light) {
        return matches.layers[static_cast<std::size_t>(light)];
    };
    if (!matches.in_place) {
        const gl::Texture old = std::move(depths_);
        depths_ = make("optical depth to lights", count);
        for (int i = 0; i < count; ++i)
            if (layer_of(i) >= 0)
                copy_layer(tools_.device, old, layer_of(i), depths_, i,
                           lattice_.count + kBeyondLattice);
    }
    lights_ = wanted_;
    placed_ = static_cast<std::size_t>(
        std::count_if(lights.lights().begin(), lights.lights().end(), [](const Light& light) {
            return std::holds_alternative<PointLight>(light) ||
                   std::holds_alternative<SpotLight>(light);
        }));
    packed_ = false;
    const glm::dvec3 eye = centre_of(lattice_);
    if (!matches.all) {
        media.bind(eye, true);
        lights.bind(eye);
    }
    for (int i = 0; i < count; ++i) {
        const LightPosition& light = lights_[static_cast<std::size_t>(i)];
        if (layer_of(i) < 0)
            fill(depths_, i, light, 0, slices_of(light), eye);
    }
}

void LightDepths::begin_refill()
{
    const int count = static_cast<int>(wanted_.size());
    refill_.emplace(Refill{});
    refill_->lights = wanted_;
    int slices = 0;
    for (int i = 0; i < count; ++i) {
        const LightPosition& wanted = wanted_[static_cast<std::size_t>(i)];
        if (is_same(lights_[static_cast<std::size_t>(i)], wanted))
            continue;
        refill_->layers.push_back(i);
        slices += slices_of(wanted);
    }
    refill_->a_frame = (slices + refill_frames_ - 1) / refill_frames_;
    refill_->depths = make("optical depth to moved lights", count);
    for (int i = 0; i < count; ++i)
        copy_layer(tools_.device, depths_, i, refill_->depths, i, lattice_.count + kBeyondLattice);
}

bool LightDepths::go_on(medium::MediaSet& media)
{
    if (!refill_)
        return false;
    const glm::dvec3 eye = centre_of(lattice_);
    media.bind(eye);
    fill_more(eye);
    if (refill_->layer < refill_->layers.size())
        return false;
    depths_ = std::move(refill_->depths);
    packed_ = false;
    lights_ = std::move(refill_->lights);
    refill_.reset();
    ++refills_;
    const bool done =
        std::equal(lights_.begin(), lights_.end(), wanted_.begin(),
                   [&](const LightPosition& a, const LightPosition& b) { return is_same(a, b); });
    if (!done)
        begin_refill();
    else
        extinction_.drop();
    return true;
}

void LightDepths::fill_more(glm::dvec3 eye)
{
    for (int left = refill_->a_frame; left > 0 && refill_->layer < refill_->layers.size();) {
        const int layer = refill_->layers[refill_->layer];
        const LightPosition& light = refill_->lights[static_cast<std::size_t>(layer)];
        const int slices = slices_of(light);
        const int now = std::min(left, slices - refill_->slices);
        fill(refill_->depths, layer, light, refill_->slices, now, eye);
        left -= now;
        refill_->slices += now;
        if (refill_->slices == slices) {
            refill_->slices = 0;
            ++refill_->layer;
        }
    }
}

gl::Texture LightDepths::make(const char* label, int layers) const
{
    const bool colored = extinction_.is_colored();
    Lattice texels = lattice_;
    texels.count += kBeyondLattice;
    gl::Texture depths =
        make_volume(tools_.device, label, texels, layers, colored ? GL_RGBA16F : GL_R16F);
    // A fetch on the last node of a layer that is not a sun's takes the texel behind it too, times
    // 0.
    tools_.device->ClearTexImage(depths.id(), 0, colored ? GL_RGBA : GL_RED, GL_FLOAT, nullptr);
    return depths;
}

int LightDepths::slices_of(const LightPosition& light) const
{
    if (!light.far)
        return lattice_.count.z;
    return lattice_.count[(columns_of(light).axis + 2) % 3] + kBeyondLattice - 1;
}

void LightDepths::fill(const gl::Texture& depths, int layer, const LightPosition& light,
                       int first_slice, int slices, glm::dvec3 eye)
{
    shared::LightVolumesParams& params = tools_.params;
    params.layer = layer;
    params.first_slice = first_slice;
    if (first_slice == 0)
        ++layers_filled_;
    const GLenum format = extinction_.is_colored() ? GL_RGBA16F : GL_R16F;
    if (!light.far) {
        params.light = glm::vec3(light.at + (place_of(lattice_).origin - eye));
        bind_block(eye);
        extinction_.volume().bind(EXTINCTION_VOLUME_UNIT);
        tools_.dispatch("light/depth.comp", fill_defines_, depths, format, VOLUME_GROUP,
                        {lattice_.count.x, lattice_.count.y, slices});
        return;
    }
    params.filled = columns_of(light);
    const glm::dvec3 way = params.filled.shear + params.filled.normal;
    params.samples = static_cast<int>(std::ceil(std::clamp(
        kSamplesPerVoxel * glm::length(voxels_from_node_ * way) - 1e-6, 1.0, kMostColumnSamples)));
    bind_block(eye);
    const int columns = lattice_.count[(params.filled.axis + 1) % 3] + kBeyondLattice - 1;
    tools_.dispatch("light/columns.comp", fill_defines_, depths, format, COLUMN_GROUP,
                    {columns, slices, 1});
}

void LightDepths::bind_block(glm::dvec3 eye) const
{
    if (extinction_)
        extinction_.write_params(eye);
    write_params(tools_.params, eye);
    tools_.bind_block();
}

shared::SunColumns LightDepths::columns_of(const LightPosition& sun) const
{
    const glm::dvec3 way = glm::dmat3(lattice_.node_from_world) * sun.at;
    const glm::dvec3 along = glm::abs(way);
    const int axis = along.x >= std::max(along.y, along.z) ? 0 : along.y >= along.z ? 1 : 2;
    shared::SunColumns columns{};
    columns.shear = glm::vec3(way / way[axis]);
    columns.shear[axis] = 0;
    columns.axis = axis;
    columns.normal[axis] = 1;
    columns.to_last = way[axis] > 0 ? 1 : 0;
    return columns;
}

void LightDepths::write_params(shared::LightVolumesParams& params, glm::dvec3 eye) const
{
    params.depth = to_shared(lattice_, 1, eye);
    params.depth_period = glm::vec3(lattice_.count + kBeyondLattice - 1);
    const glm::ivec3 texels = lattice_.count + kBeyondLattice;
    params.depth.inverse_size =
        1.0f / glm::vec3(texels * glm::ivec3(1, 1, static_cast<int>(lights_.size())));
    const auto packed = static_cast<int>(packs().size());
    params.packed_scale = 1.0f / static_cast<float>(texels.z * std::max(packed, 1));
    for (std::size_t i = 0; i < std::min<std::size_t>(lights_.size(), MAX_LIGHTS); ++i)
        if (lights_[i].far)
            params.suns[i] = lookup_of(params, columns_of(lights_[i]), static_cast<int>(i), eye);
    params.period_size = params.depth_period * params.depth.inverse_size;
    params.packed_period_z = params.depth_period.z * params.packed_scale;
}

shared::SunLookup LightDepths::lookup_of(const shared::LightVolumesParams& params,
                                         const shared::SunColumns& columns, int layer,
                                         glm::dvec3 eye) const
{
    constexpr double kLeastShear = 1e-6;  // of the lattice's width: far less than a float shows
    const int axis = columns.axis;
    const double towards = columns.to_last != 0 ? 1 : -1;
    const glm::dvec3 period(params.depth_period), last(lattice_.count - 1);
    const glm::dmat4 rows =
        glm::transpose(lattice_.node_from_world * glm::translate(glm::dmat4(1.0), eye));
    glm::dmat4 column_from_world(0.0);
    shared::SunLookup lookup{};
    for (int i = 0; i < 3; ++i) {
        const double shear = i == axis ? 0 : static_cast<double>(columns.shear[i]);
        column_from_world[i] = (rows[i] - shear * rows[axis]) / period[i];
        // From one side of the lattice to the other the column is inside while its planes are
        // between 0 and `across`, from where it stands on.
        double across = towards * last[i] / period[i];
        if (i != axis) {
            const double a_plane = towards * shear * period[axis] / period[i];
            const double slope = std::copysign(std::max(std::abs(a_plane), kLeastShear), a_plane);
            lookup.per_period[i] = static_cast<float>(-1 / slope);
            across = last[i] / period[i] / slope;
        }
        lookup.enters[i] = static_cast<float>(std::min(across, 0.0));
        lookup.across[i] = static_cast<float>(std::abs(across));
    }
    column_from_world[3] = towards * rows[axis] / period[axis];
    lookup.column_from_world = glm::mat4(glm::transpose(column_from_world));
    lookup.towards[axis] = static_cast<float>(towards);
    lookup.first = 0.5f * params.depth.inverse_size;
    const float z = 0.5f + static_cast<float>(layer) * (params.depth_period.z + 1);
    lookup.first.z = z * params.depth.inverse_size.z;
    lookup.first_z = z * params.packed_scale;
    return lookup;
}

std::vector<glm::ivec2> LightDepths::packs() const
{
    constexpr int kChannels = 4;
    std::vector<glm::ivec2> packs;
    const int lights = static_cast<int>(lights_.size());
    int suns = 0;
    while (suns < lights && lights_[static_cast<std::size_t>(suns)].far)
        packs.emplace_back(suns++, 1);
    if (extinction_.is_colored() || placed_ < 2)
        return {};
    // The points of an area are asked four at a time: they begin a texel of their own.
    const int areas = suns + static_cast<int>(placed_);
    for (int first = suns; first < lights;) {
        const int end = std::min(first + kChannels, first < areas ? areas : lights);
        packs.emplace_back(first, end - first);
        first = end;
    }
    return packs;
}

void LightDepths::pack(glm::dvec3 eye)
{
    if (packed_ || !depths_)
        return;
    packed_ = true;
    const std::vector<glm::ivec2> packs = this->packs();
    if (packs.empty()) {
        packed_depths_ = {};
        return;
    }
    Lattice texels = lattice_;
    texels.count += kBeyondLattice;
    const int layers = static_cast<int>(packs.size());
    if (packed_depths_.size() != texels.count * glm::ivec3(1, 1, layers))
        packed_depths_ = make_volume(tools_.device, "packed optical depth to lights", texels,
                                     layers, GL_RGBA16F);
    bind();
    for (int layer = 0; layer < layers; ++layer) {
        const glm::ivec2& pack = packs[static_cast<std::size_t>(layer)];
        tools_.params.layer = layer;
        tools_.params.first_slice = pack.x;
        tools_.params.samples = pack.y;
        bind_block(eye);
        tools_.dispatch("light/pack_depths.comp", {}, packed_depths_, GL_RGBA16F, VOLUME_GROUP,
                        texels.count);
    }
}

gl::Defines LightDepths::defines() const
{
    gl::Defines defines;
    if (depths_)
        defines.emplace_back("kDepthVolume", "");
    if (depths_ && extinction_.is_colored())
        defines.emplace_back("VOLUME_RGB", "");
    return defines;
}

glm::dvec3 LightDepths::blur() const
{
    // The eight nodes around a place are one from each other along the lattice and, as columns
    // stand askew, at most one more.
    constexpr double kNodes = 2;
    if (!depths_)
        return glm::dvec3(0);
    const glm::dmat3 edges = glm::inverse(glm::dmat3(lattice_.node_from_world));
    return kNodes * (glm::abs(edges[0]) + glm::abs(edges[1]) + glm::abs(edges[2]));
}

std::string LightDepths::describe() const
{
    const int layers = static_cast<int>(lights_.size());
    const std::size_t packed = packs().size();
    return fmt::format(
        "optical depth to {} light{}: {}{}, filled{}: {} a sample", layers, layers == 1 ? "" : "s",
        size_of(depths_, layers, extinction_.is_colored() ? 8 : 2),
        extinction_.is_colored() ? ", coloured" : "", filled_in(ms_),
        packed == 0 || layers == 1
            ? "one fetch"
            : fmt::format("{} fetch{}, for a march of four far lights each, else one a light",
                          packed, packed == 1 ? "" : "es"));
}

}  // namespace fumarole::light
