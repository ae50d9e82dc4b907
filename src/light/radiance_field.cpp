#include "light/radiance_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <glm/gtc/epsilon.hpp>
#include <glm/gtc/matrix_transform.hpp>

#include "light/lattice_ways.h"
#include "light/nodes_near_surfaces.h"
#include "light/world_light.h"
#include "shared/bindings.h"
#include "shared/field_nodes.h"

namespace fumarole::light {

namespace {

constexpr glm::ivec3 kVolumeGroup(VOLUME_GROUP), kChainGroup(8, 8, 1);

/// In the image of the ways of a batch, of the world's light alone: the field takes all its ways at
/// once.
constexpr std::int64_t kMostBytes = 64 << 20;
constexpr std::int64_t kWayBytes = 12;  ///< a node, of both

/// Of all ways: to where light comes from, unit length, eye-centred world. Their own axes are at
/// right angles whatever the lattice's are.
std::vector<glm::dvec3> to_lights(const std::vector<LatticeWay>& ways, const FieldLattice& lattice)
{
    const glm::dmat3 metres_from_node = glm::inverse(glm::dmat3(lattice.node_from_eye));
    const glm::dvec3 x = glm::normalize(metres_from_node[0]);
    const glm::dvec3 z = glm::normalize(glm::cross(x, metres_from_node[1]));
    glm::dmat3 axes(x, glm::cross(z, x), z);
    const glm::dvec3 edges(glm::length(metres_from_node[0]), glm::length(metres_from_node[1]),
                           glm::length(metres_from_node[2]));
    const bool cubes = glm::all(glm::epsilonEqual(edges, glm::dvec3(edges.x), 1e-6 * edges.x));
    if (!cubes) {
        // No step leads from node to node anyway. Turned, no way lies in the plane of a flat
        // medium, and no two leave it at the same slant.
        constexpr double kTurn = 0.6;
        const glm::dmat4 turned = glm::rotate(glm::dmat4(1.0), kTurn, glm::dvec3(1, 2, 3));
        axes = axes * glm::dmat3(turned);
    }
    std::vector<glm::dvec3> wi;
    wi.reserve(ways.size());
    for (const LatticeWay& way : ways)
        wi.push_back(-(axes * glm::normalize(glm::dvec3(way.step))));
    return wi;
}

/// FieldWay::beside. Light that comes from lower goes up.
int ways_beside(const std::vector<LatticeWay>& ways, glm::ivec3 step, int axis)
{
    int all = 0;
    for (int i = 0; i < 4; ++i) {
        glm::ivec3 tilted = step;
        tilted[(axis + 1 + i / 2) % 3] += i % 2 == 0 ? 1 : -1;
        const auto found = std::find_if(ways.begin(), ways.end(),
                                        [&](const LatticeWay& way) { return way.step == tilted; });
        if (found != ways.end())
            all |= static_cast<int>(found - ways.begin()) << (8 * i);
    }
    return all;
}

/// The world's radiance along each of them.
std::vector<glm::vec3> entries(const World* world, const std::vector<LatticeWay>& ways,
                               const std::vector<glm::dvec3>& wi)
{
    if (world == nullptr || world->environment == nullptr)
        return std::vector<glm::vec3>(ways.size(),
                                      world != nullptr ? world->radiance : glm::vec3(0.0f));
    std::vector<double> solid_angles;
    solid_angles.reserve(ways.size());
    for (const LatticeWay& way : ways)
        solid_angles.push_back(way.solid_angle);
    return world_radiance(*world, wi, solid_angles);
}

glm::dvec3 to_axes(int axis, glm::dvec3 q)
{
    return {q[axis], q[(axis + 1) % 3], q[(axis + 2) % 3]};
}

/// How light that comes from `wi` goes through a lattice's slices.
void set_course(shared::FieldWay& way, glm::dvec3 wi, const FieldLattice& lattice)
{
    constexpr double kRounding = 1e-6;
    const glm::dvec3 d = glm::dmat3(lattice.node_from_eye) * -wi;  // nodes a metre
    const glm::dvec3 size = glm::abs(d) * (1.0 + kRounding * glm::dvec3(2, 1, 0));
    way.axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const glm::dvec3 course = to_axes(way.axis, d) / std::abs(d[way.axis]);
    way.forward = course.x > 0 ? 1.0f : -1.0f;
    way.metres = static_cast<float>(1 / std::abs(d[way.axis]));
    for (int i = 0; i < 2; ++i) {
        // Halves and wholes as they are meant.
        const double half = std::round(2 * course[i + 1]) / 2;
        way.slope[i] =
            static_cast<float>(std::abs(course[i + 1] - half) < kRounding ? half : course[i + 1]);
    }
}

/// The lines along a way through the nodes of slices: the first of them across, and how many.
struct Lines {
    glm::ivec2 first{0}, count{0};
};

Lines lines_of(const shared::FieldWay& way, glm::dvec3 last)
{
    Lines lines;
    for (int i = 0; i < 2; ++i) {
        const double shift = static_cast<double>(way.slope[i]) * last.x;
        lines.first[i] = static_cast<int>(std::floor(std::min(-shift, 0.0))) - 1;
        lines.count[i] = static_cast<int>(last[i + 1] + std::ceil(std::abs(shift))) + 4;
    }
    return lines;
}

/// Of the lines that what lies in the lattice is drawn along, and of the two that part from the way
/// for what lies beyond it.
constexpr std::array kTilts{0.0f, 0.2f, -0.2f};

/// Pixels from the first line of a way to that of the one beside it: whole squares that a software
/// rasteriser hands to its threads.
int apart(int lines)
{
    constexpr int kSquare = 64;
    return (lines + kSquare - 1) / kSquare * kSquare;
}

/// That takes the lines along any way, or so many parts of each.
glm::ivec2 framebuffer_size(glm::ivec3 nodes, int parts)
{
    const int lines = 2 * std::max({nodes.x, nodes.y, nodes.z}) + 4;
    if (parts > 1)
        return glm::ivec2(parts * lines);
    return {lines + (FIELD_WAYS_BESIDE - 1) * apart(lines), lines};
}

/// Ways that walls are looked for along: the axes, and the diagonals too.
constexpr int kAxisWays = 6, kSightWays = 26;

/// In nodes, to where light of that way comes from: as glsl/light/steps.glsl has them.
glm::dvec3 wall_step(int way)
{
    constexpr int kFaceWays = 12;
    const auto side = [](int bit) { return bit % 2 == 0 ? -1.0 : 1.0; };
    glm::dvec3 step(0);
    if (way < kAxisWays) {
        step[way / 2] = side(way);
    } else if (way < kAxisWays + kFaceWays) {
        const int face = way - kAxisWays;
        step[(face / 4 + 1) % 3] = side(face);
        step[(face / 4 + 2) % 3] = side(face / 2);
    } else {
        const int octant = way - kAxisWays - kFaceWays;
        step = {side(octant), side(octant / 2), side(octant / 4)};
    }
    return step;
}

/// Metres, world: of a lattice, as far as light/line.glsl takes a surface to lie in it.
Bounds rim_of(const FieldLattice& lattice)
{
    constexpr double kRim = 0.01;  // nodes
    Bounds nodes;
    nodes.add(glm::dvec3(-kRim));
    nodes.add(glm::dvec3(lattice.count - 1) + kRim);
    return nodes.transformed(
        glm::inverse(lattice.node_from_eye * glm::translate(glm::dmat4(1.0), -lattice.eye)));
}

}  // namespace

/// What is there from begin() to end().
struct RadianceField::Filling {
    FieldLattice lattice;
    FieldMedium medium;
    struct Ways {
        std::vector<LatticeWay> ways;
        std::vector<glm::dvec3> wi;    ///< directions to where light comes from, unit length
        std::vector<glm::vec3> entry;  ///< the world's radiance along each
    };
    Ways near, all;     ///< the kNearWays and the kAllWays directions
    bool ends = false;  ///< media end at some of the lattice's faces
    int batch = 0;      ///< ways that there is room for
    gl::Texture sigma_t, albedo, emission;
    gl::Texture taken;           ///< light/field_taken.glsl; empty: FieldMedium::mixed_g
    gl::Buffer nodes;            ///< a FieldNodesHead and the nodes that light is scattered at
    gl::Buffer looked_up;        ///< likewise of those that surfaces look it up at; empty: any
    gl::Texture marched;         ///< sigma_t of the marched media, where there are others too
    gl::Texture steps_to_walls;  ///< as they are drawn
    gl::Texture walls;           ///< walls between nodes, as take_walls()
    gl::Texture sights;          ///< as take_sights()
    const gl::Texture* sky_shares = nullptr;  ///< light/sky_share.comp; null: all or nothing
    gl::Texture clear, dimmed;                ///< coefficients of the world's light
    gl::Texture of_world;                     ///< dimmed, before add_light()
    gl::Texture bounced;                      ///< coefficients of what surfaces send on
    gl::Texture bounced_before, bounced_before_that;  ///< a turn and two turns ago
    gl::Texture materials;   ///< each surface's albedo, and in row 1 its emission
    gl::Texture lamps;       ///< light/lamps.comp; empty: there are none
    gl::Texture of_lamps;    ///< coefficients of what they send
    gl::Texture emitted;     ///< light/face_emission.comp; empty: no surface emits
    gl::Texture face_light;  ///< what they send on
    gl::Texture clearance;   ///< light/clearance.glsl
    gl::Texture beyond;      ///< what surfaces beyond send in, two layers a way; alpha: metres
    bool sends_in = false;   ///< there are some
    gl::Texture ways;        ///< radiance of each way of a batch: the world's, the surfaces'
    gl::Texture light_ways;  ///< radiance of each way of what media emit and scatter
};

/// What surfaces leave where they are drawn along the lattice's ways: media and lights, which
/// change more often, have no part in it.
struct RadianceField::Drawn {
    struct Key {
        int shape = 0, ways = 0;
        bool bounces = false;
        glm::ivec3 count{0};
        glm::dmat4 node_from_eye{1.0};
        glm::dvec3 eye{0};
        bool operator==(const Key&) const = default;
    };
    Key key;
    gl::Texture crossed;  ///< light/crossings.comp; empty: no surface
    gl::Texture faces;    ///< light/faces.glsl, six layers; empty: they send nothing on
};

/// Some of a set of ways that are walked at once.
struct RadianceField::Batch {
    int set = 0;  ///< kNearWays or kAllWays
    int first = 0, count = 0;
};

RadianceField::RadianceField(const gl::Device& device, gl::ProgramCache& programs)
    : device_{device}, programs_{programs}, block_{device, "field of light"},
      draw_block_{device, "surfaces in the field"}, drawn_{std::make_unique<Drawn>()}
{
}

RadianceField::~RadianceField() = default;

void RadianceField::dispatch(const char* file, gl::Defines defines, glm::ivec3 threads,
                             glm::ivec3 group) const
{
    if (filling_->medium.thick)
        defines.emplace_back("kPrecise", "");
    device_->UseProgram(programs_.get({file}, defines).id());
    const glm::uvec3 groups((threads + group - 1) / group);
    device_->DispatchCompute(groups.x, groups.y, groups.z);
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void RadianceField::dispatch_nodes(const char* file, const gl::Defines& defines) const
{
    dispatch(file, defines, filling_->lattice.count, kVolumeGroup);
}

void RadianceField::dispatch_over(const gl::Buffer& nodes, const char* file,
                                  gl::Defines defines) const
{
    if (!nodes) {
        dispatch_nodes(file, defines);
        return;
    }
    defines.emplace_back("kListed", "");
    if (filling_->medium.thick)
        defines.emplace_back("kPrecise", "");
    device_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, FIELD_NODES_BUFFER, nodes.id());
    device_->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, nodes.id());
    device_->UseProgram(programs_.get({file}, defines).id());
    device_->DispatchComputeIndirect(0);
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void RadianceField::dispatch_listed(const char* file, const gl::Defines& defines) const
{
    dispatch_over(filling_->nodes, file, defines);
}

void RadianceField::dispatch_at(Nodes nodes, const char* file, const gl::Defines& defines) const
{
    if (nodes == Nodes::all)
        dispatch_nodes(file, defines);
    else
        dispatch_over(nodes == Nodes::listed ? filling_->nodes : filling_->looked_up, file,
                      defines);
}

void RadianceField::list_looked_up(const surface::SurfaceSet& surfaces)
{
    const std::vector<std::uint32_t> near =
        nodes_near_surfaces(filling_->lattice, surfaces.instances(), filling_->medium.rim);
    if (near.empty())
        return;
    const auto count = static_cast<std::uint32_t>(near.size());
    const shared::FieldNodesHead head{(count + FIELD_NODE_GROUP - 1) / FIELD_NODE_GROUP, 1, 1,
                                      count};
    std::vector<std::uint32_t> words(sizeof(head) / sizeof(std::uint32_t));
    std::memcpy(words.data(), &head, sizeof(head));
    words.insert(words.end(), near.begin(), near.end());
    filling_->looked_up = {device_, "field: nodes near surfaces", words.size() * sizeof(words[0]),
                           words.data()};
}

void RadianceField::list_nodes()
{
    const glm::uvec3 count(filling_->lattice.count);
    constexpr shared::FieldNodesHead kNone{0, 1, 1, 0};
    // All at once: a buffer that is written to later on may have to be waited for.
    std::vector<std::uint32_t> words(sizeof(kNone) / sizeof(std::uint32_t) +
                                     std::size_t{count.x} * count.y * count.z);
    std::memcpy(words.data(), &kNone, sizeof(kNone));
    filling_->nodes = {device_, "field: nodes near media", words.size() * sizeof(words[0]),
                       words.data()};
    device_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, FIELD_NODES_BUFFER, filling_->nodes.id());
    filling_->sigma_t.bind(FIELD_SIGMA_T_UNIT);
    gl::Defines defines;
    if (!filling_->medium.hole.empty())
        defines.emplace_back("kHole", "");
    dispatch_nodes("light/field_list.comp", defines);
    device_->MemoryBarrier(GL_COMMAND_BARRIER_BIT | GL_SHADER_STORAGE_BARRIER_BIT);
}

void RadianceField::write_block()
{
    block_.write(params_);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, FIELD_BLOCK, block_.id());
}

void RadianceField::bind_again()
{
    filling_->medium.bind_again();
    write_block();
    drawn_->crossed.bind(FIELD_CROSSED_UNIT);
}

void RadianceField::bind_image(GLuint unit, const gl::Texture& texture, GLenum access,
                               GLenum format) const
{
    device_->BindImageTexture(unit, texture.id(), 0, GL_TRUE, 0, access, format);
}

// Of a lattice along the world's axes: of others no way lies in a box's faces. Where media differ
// in g a node's sides all count alike, and nothing is told of faces either.
void RadianceField::take_ends()
{
    constexpr double kFarOff = 1e6;  // nodes
    const FieldLattice& lattice = filling_->lattice;
    const glm::dmat4& map = lattice.node_from_eye;
    glm::dvec3 low(-kFarOff), high(kFarOff);
    bool along_axes = filling_->medium.scatters && !filling_->medium.mixed_g;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            along_axes &= i == j || std::abs(map[i][j]) < 1e-9 * std::abs(map[i][i]);
    for (int i = 0; i < 3 && along_axes; ++i) {
        const auto at = [&](double metres) {
            return map[i][i] * (metres - lattice.eye[i]) + map[3][i];
        };
        const double first = at(filling_->medium.ends.min[i]),
                     last = at(filling_->medium.ends.max[i]);
        low[i] = std::clamp(std::min(first, last), -kFarOff, kFarOff);
        high[i] = std::clamp(std::max(first, last), -kFarOff, kFarOff);
        filling_->ends |= low[i] > -kFarOff || high[i] < kFarOff;
    }
    params_.ends_low = glm::vec3(low);
    params_.ends_high = glm::vec3(high);
}

GLenum RadianceField::light_format() const
{
    return filling_->medium.thick ? GL_RG32UI : GL_R32UI;
}

gl::Texture RadianceField::make(const char* label, int layers) const
{
    return gl::Texture::make_3d(device_, label, filling_->lattice.count * glm::ivec3(1, 1, layers),
                                GL_RGBA32F, gl::Filter::linear);
}

glm::ivec3 RadianceField::ways_size(int ways) const
{
    return filling_->lattice.count *
           glm::ivec3(FIELD_WAYS_A_ROW, 1, (ways + FIELD_WAYS_A_ROW - 1) / FIELD_WAYS_A_ROW);
}

gl::Texture RadianceField::make_ways(const char* label, int ways, GLenum format) const
{
    return gl::Texture::make_3d(device_, label, ways_size(ways), format, gl::Filter::nearest);
}

void RadianceField::clear_unlisted(const gl::Texture& light) const
{
    const std::array<GLfloat, 4> none_outside{0, 0, 0, 1};
    light.clear(GL_RGBA, GL_FLOAT, none_outside.data());
}

gl::Texture RadianceField::make_sources(int ways) const
{
    gl::Texture sources = make_ways("field: scattered", ways, light_format());
    const GLuint none = 0;
    sources.clear(GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    return sources;
}

void RadianceField::begin(const FieldLattice& lattice, FieldMedium medium,
                          const surface::SurfaceSet& surfaces, bool bounces)
{
    filling_ = std::make_unique<Filling>();
    filling_->lattice = lattice;
    filling_->medium = std::move(medium);
    params_ = {};
    params_.nodes = lattice.params;
    params_.albedo = filling_->medium.albedo;
    params_.straight_on = filling_->medium.straight_on;
    params_.left_out = filling_->medium.left_out;
    if (!filling_->medium.hole.empty()) {
        const Bounds hole = filling_->medium.hole.transformed(
            lattice.node_from_eye * glm::translate(glm::dmat4(1.0), -lattice.eye));
        params_.hole_low = glm::vec3(hole.min);
        params_.hole_high = glm::vec3(hole.max);
    }
    const Bounds media = filling_->medium.bounds.transformed(
        lattice.node_from_eye * glm::translate(glm::dmat4(1.0), -lattice.eye));
    params_.media_low = glm::vec3(media.min);
    params_.media_high = glm::vec3(media.max);
    take_ends();
    for (Filling::Ways* set : {&filling_->near, &filling_->all}) {
        set->ways = lattice_ways(set == &filling_->near ? kNearWays : kAllWays);
        set->wi = to_lights(set->ways, lattice);
        set->entry = entries(filling_->medium.world, set->ways, set->wi);
    }
    const std::int64_t nodes = std::int64_t{lattice.count.x} * lattice.count.y * lattice.count.z;
    const std::int64_t most = std::max(filling_->medium.ways, kNearWays);
    filling_->batch = static_cast<int>(std::clamp(kMostBytes / (kWayBytes * nodes) / 2 * 2,
                                                  std::int64_t{kNearWays}, most));  // whole pairs
    filling_->ways = make_ways("field: ways", filling_->batch, GL_RG32UI);
    filling_->light_ways = make_ways("field: light's ways", filling_->batch, light_format());
    const Drawn::Key key{surfaces.shape(), filling_->medium.ways, bounces,
                         lattice.count,    lattice.node_from_eye, lattice.eye};
    if (surfaces.empty() || drawn_->key != key)
        *drawn_ = {key, {}, {}};
    if (!surfaces.empty() && !drawn_->crossed)
        draw(surfaces);
    if (!surfaces.empty())
        draw_walls(surfaces);
    if (!surfaces.empty() && bounces)
        take_faces(surfaces);
    sample_medium();
    // What surfaces send on is asked of all nodes.
    if (filling_->medium.sights && !bounces)
        list_looked_up(surfaces);
    if (!surfaces.empty())
        keep_walls();
    if (!surfaces.empty() && bounces)
        find_clearance();
    if (!surfaces.empty() && filling_->medium.world != nullptr && !filling_->medium.sky_box.empty())
        share_sky(surfaces);
    else
        sky_share_.reset();
}

void RadianceField::end()
{
    filling_.reset();
}

void RadianceField::forget()
{
    *drawn_ = {};
    sky_share_.reset();
}

void RadianceField::draw(const surface::SurfaceSet& surfaces)
{
    ++drawings_;
    const glm::ivec3 count = filling_->lattice.count;
    const gl::Texture crossed = gl::Texture::make_3d(
        device_, "field: surfaces as they are drawn",
        count * glm::ivec3(1, 1, 4 * FIELD_CROSSED_WORDS), GL_R32UI, gl::Filter::nearest);
    const GLuint none = 0;
    crossed.clear(GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    if (!framebuffer_)
        framebuffer_ = {device_, "field: surfaces"};
    // Of the lines along any way: of one size, since another would have a GPU or a rasteriser end
    // what it draws.
    framebuffer_.set_empty(framebuffer_size(count, 1));
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    bind_image(0, crossed, GL_READ_WRITE, GL_R32UI);
    glm::ivec2 lines(0);
    const int ways = filling_->medium.ways;
    for (int i = 0; i < ways; ++i)
        lines = glm::max(lines, set_way(i, filling_->all.wi[static_cast<std::size_t>(i)]));
    // What lies beyond the lattice is seen along two lines that part from the way: of ways along a
    // plain, one of them meets it.
    for (const int part : {0, 1, 2}) {
        const std::vector<surface::SurfaceSet::Instance> drawn =
            part == 0 ? within(surfaces) : beyond(surfaces);
        if (drawn.empty())
            continue;
        const gl::Defines defines = part == 0 ? gl::Defines{} : gl::Defines{{"kBeyond", ""}};
        device_->UseProgram(programs_.get({"light/line.vert", "light/crossed.frag"}, defines).id());
        params_.first = 32 * FIELD_CROSSED_WORDS * part;
        params_.tilt = kTilts.at(static_cast<std::size_t>(part));
        draw_lines(surfaces, drawn, ways, lines, framebuffer_);
    }
    put_side_by_side(crossed);
}

void RadianceField::put_side_by_side(const gl::Texture& crossed)
{
    constexpr int kWaysAWord = 32;
    params_.count = (filling_->medium.ways + kWaysAWord - 1) / kWaysAWord;
    write_block();
    drawn_->crossed = gl::Texture::make_3d(
        device_, "field: surfaces", filling_->lattice.count * glm::ivec3(1, 1, params_.count),
        GL_RGBA32UI, gl::Filter::nearest);
    crossed.bind(FIELD_CROSSED_UNIT);
    bind_image(0, drawn_->crossed, GL_WRITE_ONLY, GL_RGBA32UI);
    dispatch_nodes("light/crossings.comp", {});
}

void RadianceField::wait_for_drawing()
{
    // llvmpipe may start a compute shader while what was drawn for it is still on its way; any
    // barrier makes it finish that first. GL asks for none here, and elsewhere this one costs
    // nothing.
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

std::vector<surface::SurfaceSet::Instance>
RadianceField::within(const surface::SurfaceSet& surfaces) const
{
    const Bounds box = rim_of(filling_->lattice);
    std::vector<surface::SurfaceSet::Instance> out;
    for (const auto& instance : surfaces.instances())
        if (instance.bounds.meets(box))
            out.push_back(instance);
    return out;
}

std::vector<surface::SurfaceSet::Instance>
RadianceField::beyond(const surface::SurfaceSet& surfaces) const
{
    const Bounds box = rim_of(filling_->lattice);
    std::vector<surface::SurfaceSet::Instance> out;
    for (const auto& instance : surfaces.instances())
        if (!box.contains(instance.bounds))
            out.push_back(instance);
    return out;
}

glm::ivec2 RadianceField::set_way(int slot, glm::dvec3 wi)
{
    const FieldLattice& lattice = filling_->lattice;
    shared::FieldWay& way = params_.ways[slot];
    set_course(way, wi, lattice);
    way.wi = glm::vec3(wi);
    const Lines lines = lines_of(way, to_axes(way.axis, glm::dvec3(lattice.count - 1)));
    way.first_line = lines.first;
    return lines.count;
}

void RadianceField::draw_lines(const surface::SurfaceSet& surfaces,
                               const std::vector<surface::SurfaceSet::Instance>& drawn, int ways,
                               glm::ivec2 lines, const gl::Framebuffer& target, int parts)
{
    // A ball of so few nodes across is drawn coarsely: what bits tell of it is as coarse.
    constexpr double kFewNodes = 12;
    using Detail = surface::SurfaceSet::Detail;
    // Parts of faces take several squares as they are.
    const int beside = parts == 1 ? std::min(ways, FIELD_WAYS_BESIDE) : 1;
    params_.apart = beside > 1 ? apart(lines.x) : 0;
    params_.lines = lines + glm::ivec2((beside - 1) * params_.apart, 0);
    write_block();
    target.bind(parts * params_.lines);
    for (const int i : {0, 1, 2})
        device_->Enable(GL_CLIP_DISTANCE0 + i);
    for (const auto& instance : drawn) {
        const glm::dvec3 nodes = glm::dmat3(filling_->lattice.node_from_eye) *
                                 (instance.bounds.max - instance.bounds.min);
        const bool small = glm::length(nodes) < kFewNodes * std::sqrt(3);
        shared::DrawParams params{};
        params.world_from_object = glm::mat4(
            glm::translate(glm::dmat4(1.0), -filling_->lattice.eye) * instance.world_from_object);
        params.albedo = instance.albedo;
        params.emission = instance.emission;
        params.number = static_cast<int>(&instance - drawn.data());
        params.is_open = instance.closed ? 0 : 1;
        draw_block_.write(params);
        surfaces.draw(instance, small ? Detail::coarsest : Detail::coarse, ways);
    }
    for (const int i : {0, 1, 2})
        device_->Disable(GL_CLIP_DISTANCE0 + i);
}

void RadianceField::draw_along_axes(const surface::SurfaceSet& surfaces, const gl::Texture& to,
                                    const gl::Defines& variant, int ways, int parts)
{
    const glm::dmat3 metres_from_node = glm::inverse(glm::dmat3(filling_->lattice.node_from_eye));
    const GLuint none = ~0u;
    to.clear(GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    bind_image(0, to, GL_READ_WRITE, GL_R32UI);
    device_->UseProgram(programs_.get({"light/line.vert", "light/crossed.frag"}, variant).id());
    const std::vector<surface::SurfaceSet::Instance> all(surfaces.instances().begin(),
                                                         surfaces.instances().end());
    glm::ivec2 lines(0);
    // Light that goes up an axis meets a node's wall below it.
    for (int way = 0; way < ways; ++way)
        lines = glm::max(lines, set_way(way, glm::normalize(metres_from_node * wall_step(way))));
    params_.tilt = 0;
    framebuffer_.set_empty(framebuffer_size(filling_->lattice.count, parts));
    draw_lines(surfaces, all, ways, lines, framebuffer_, parts);
    wait_for_drawing();
}

void RadianceField::draw_walls(const surface::SurfaceSet& surfaces)
{
    const int ways = filling_->medium.sights ? kSightWays : kAxisWays;
    filling_->steps_to_walls = make_ways("field: steps to walls", ways, GL_R32UI);
    draw_along_axes(surfaces, filling_->steps_to_walls, {{"kWalls", ""}}, ways);
}

void RadianceField::keep_walls()
{
    Filling& filling = *filling_;
    const glm::ivec3 count = filling.lattice.count;
    filling.walls =
        gl::Texture::make_3d(device_, "walls between nodes", count * glm::ivec3(1, 1, 2),
                             GL_RGBA16F, gl::Filter::nearest);
    filling.steps_to_walls.bind(FIELD_CROSSED_UNIT);
    bind_image(0, filling.walls, GL_WRITE_ONLY, GL_RGBA16F);
    dispatch_nodes("light/walls.comp", {});
    if (!filling.medium.sights)
        filling.steps_to_walls = {};
}

void RadianceField::find_sights(const gl::Texture& light)
{
    Filling& filling = *filling_;
    if (!filling.steps_to_walls)
        return;
    constexpr int kOctants = 8;
    filling.sights = gl::Texture::make_3d(device_, "how far nodes see",
                                          filling.lattice.count * glm::ivec3(1, 1, kOctants),
                                          GL_RG32UI, gl::Filter::nearest);
    gl::Defines defines;
    const gl::Texture& sigma_t = filling.sigma_t ? filling.sigma_t : filling.marched;
    if (sigma_t && filling.medium.dims) {
        defines.emplace_back("kDims", "");
        sigma_t.bind(FIELD_SIGMA_T_UNIT);
    }
    light.bind(WORLD_ON_SURFACES_UNIT);
    filling.steps_to_walls.bind(FIELD_CROSSED_UNIT);
    write_block();
    bind_image(0, filling.sights, GL_WRITE_ONLY, GL_RG32UI);
    dispatch_at(Nodes::looked_up, "light/sights.comp", defines);
    filling.steps_to_walls = {};
}

void RadianceField::find_clearance()
{
    Filling& filling = *filling_;
    for (int axis = 0; axis < 3; ++axis) {
        const GLenum format = axis < 2 ? GL_R8UI : GL_RG32UI;
        gl::Texture next = gl::Texture::make_3d(device_, "field: clearance", filling.lattice.count,
                                                format, gl::Filter::nearest);
        filling.walls.bind(WALLS_UNIT);
        filling.clearance.bind(FIELD_CROSSED_UNIT);
        bind_image(0, next, GL_WRITE_ONLY, format);
        dispatch_nodes("light/clearance.comp", {{"kAxis", fmt::format("{}", axis)}});
        filling.clearance = std::move(next);
    }
}

void RadianceField::see_fire(const gl::Texture& light, const gl::Texture& to)
{
    if (!filling_->clearance)
        find_clearance();
    write_block();
    filling_->clearance.bind(FIELD_CROSSED_UNIT);
    light.bind(FIELD_LIGHT_UNIT);
    bind_image(0, to, GL_WRITE_ONLY, GL_RGBA16F);
    dispatch_at(Nodes::looked_up, "light/fire_seen.comp", {});
}

void RadianceField::share_sky(const surface::SurfaceSet& surfaces)
{
    Filling& filling = *filling_;
    const Filling::Ways& set = filling.medium.ways == kNearWays ? filling.near : filling.all;
    if (!sky_share_)
        sky_share_ = std::make_unique<SkyShare>(device_, programs_);
    write_block();
    filling.sky_shares = &sky_share_->shares(filling.lattice, set.wi, filling.medium.sky_box,
                                             surfaces, ways_size(filling.medium.ways));
}

void RadianceField::take_faces(const surface::SurfaceSet& surfaces)
{
    Filling& filling = *filling_;
    const glm::ivec3 six = filling.lattice.count * glm::ivec3(1, 1, 6);
    if (!drawn_->faces) {
        drawn_->faces =
            gl::Texture::make_3d(device_, "field: faces", six, GL_R32UI, gl::Filter::nearest);
        draw_along_axes(surfaces, drawn_->faces, {{"kFaces", ""}}, kAxisWays);
    }
    filling.face_light = gl::Texture::make_3d(device_, "field: light of faces", six, GL_RGBA16F,
                                              gl::Filter::nearest);
    const std::array<GLfloat, 4> none{};
    filling.face_light.clear(GL_RGBA, GL_FLOAT, none.data());
    const auto& drawn = surfaces.instances();
    std::vector<glm::vec4> materials;
    for (const auto& instance : drawn)
        materials.emplace_back(instance.albedo, 1.0f);
    for (const auto& instance : drawn)
        materials.emplace_back(instance.emission, 1.0f);
    for (const std::size_t lamp : find_lamps(surfaces))
        materials[drawn.size() + lamp] = {0, 0, 0, 1};
    filling.materials =
        gl::Texture::make_2d(device_, "field: what surfaces are made of",
                             {static_cast<int>(drawn.size()), 2}, GL_RGBA32F, gl::Filter::nearest);
    filling.materials.upload(GL_RGBA, GL_FLOAT, materials.data());
    const auto emissions = materials.begin() + std::ssize(drawn);
    if (std::any_of(emissions, materials.end(),
                    [](glm::vec4 emission) { return glm::vec3(emission) != glm::vec3(0); }))
        find_emission(surfaces);
}

std::vector<std::size_t> RadianceField::find_lamps(const surface::SurfaceSet& surfaces)
{
    Filling& filling = *filling_;
    constexpr double kMostNodes = 2.5;  // across
    constexpr std::size_t kMost = 64, kRows = 4;
    const Bounds box = rim_of(filling.lattice);
    std::vector<std::size_t> lamps;
    const auto& all = surfaces.instances();
    for (std::size_t i = 0; i < all.size() && lamps.size() < kMost; ++i) {
        const glm::dvec3 size = all[i].bounds.max - all[i].bounds.min;
        if (all[i].emission != glm::vec3(0) && box.contains(all[i].bounds) &&
            std::max({size.x, size.y, size.z}) <=
                kMostNodes * double(filling.lattice.params.spacing))
            lamps.push_back(i);
    }
    if (lamps.empty())
        return lamps;
    std::vector<glm::vec4> texels(kRows * lamps.size());
    for (std::size_t i = 0; i < lamps.size(); ++i) {
        const auto& lamp = all[lamps[i]];
        const auto row = [&](std::size_t at) -> glm::vec4& {
            return texels[at * lamps.size() + i];
        };
        const glm::dvec3 middle = (lamp.bounds.min + lamp.bounds.max) / 2.0 - filling.lattice.eye;
        row(0) = glm::vec4(middle, static_cast<float>(lamps[i]));
        row(1) = glm::vec4((lamp.bounds.max - lamp.bounds.min) / 2.0, lamp.is_box ? 1 : 0);
        row(2) = glm::vec4(lamp.seen_areas, 0);
        row(3) = glm::vec4(lamp.emission, 0);
    }
    filling.lamps = gl::Texture::make_2d(device_, "field: lamps",
                                         {static_cast<int>(lamps.size()), static_cast<int>(kRows)},
                                         GL_RGBA32F, gl::Filter::nearest);
    filling.lamps.upload(GL_RGBA, GL_FLOAT, texels.data());
    return lamps;
}

bool RadianceField::begin_by_lamps(int bands, const gl::Texture& to)
{
    Filling& filling = *filling_;
    if (!filling.lamps)
        return false;
    if (!filling.of_lamps) {
        filling.of_lamps = make("field: of lamps", bands * bands);
        gl::Defines defines = bounce_defines();
        defines.emplace_back("kBands", fmt::format("{}", bands));
        write_block();
        (filling.marched ? filling.marched : filling.sigma_t).bind(FIELD_SIGMA_T_UNIT);
        filling.clearance.bind(FIELD_CROSSED_UNIT);
        drawn_->faces.bind(FACES_UNIT);
        filling.lamps.bind(FACE_MATERIALS_UNIT);
        bind_image(0, filling.of_lamps, GL_WRITE_ONLY);
        dispatch_nodes("light/lamps.comp", defines);
    }
    copy(filling.of_lamps, to);
    return true;
}

void RadianceField::copy(const gl::Texture& from, const gl::Texture& to) const
{
    const glm::ivec3 size = from.size();
    device_->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT);  // after the stores that filled it
    device_->CopyImageSubData(from.id(), GL_TEXTURE_3D, 0, 0, 0, 0, to.id(), GL_TEXTURE_3D, 0, 0, 0,
                              0, size.x, size.y, size.z);
    device_->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

void RadianceField::find_emission(const surface::SurfaceSet& surfaces)
{
    Filling& filling = *filling_;
    const glm::ivec3 six = filling.lattice.count * glm::ivec3(1, 1, 6);
    const gl::Texture parts = gl::Texture::make_3d(device_, "field: parts of faces",
                                                   six * glm::ivec3(FACE_PARTS * FACE_PARTS, 1, 1),
                                                   GL_R32UI, gl::Filter::nearest);
    draw_along_axes(surfaces, parts, {{"kFaces", ""}, {"kParts", ""}}, kAxisWays, FACE_PARTS);
    filling.emitted = gl::Texture::make_3d(device_, "field: emission of faces", six, GL_RGBA16F,
                                           gl::Filter::nearest);
    parts.bind(FACES_UNIT);
    filling.materials.bind(FACE_MATERIALS_UNIT);
    bind_image(0, filling.emitted, GL_WRITE_ONLY, GL_RGBA16F);
    dispatch("light/face_emission.comp", {}, six, kVolumeGroup);
}

void RadianceField::draw_beyond(const gl::Defines& shading, const surface::SurfaceSet& surfaces)
{
    Filling& filling = *filling_;
    const std::vector<surface::SurfaceSet::Instance> drawn = beyond(surfaces);
    const auto& ways = filling.all.wi;
    glm::ivec2 size(0);
    for (const glm::dvec3& wi : ways)
        size = glm::max(size, set_way(0, wi));
    filling.beyond = gl::Texture::make_2d_array(device_, "field: light from beyond",
                                                {size, 2 * static_cast<int>(ways.size())},
                                                GL_RGBA16F, gl::Filter::nearest);
    const GLfloat none[4]{};
    filling.beyond.clear(GL_RGBA, GL_FLOAT, none);
    filling.sends_in = !drawn.empty();
    if (drawn.empty())
        return;
    const gl::Texture depth = gl::Texture::make_2d(device_, "field: depth beyond", size,
                                                   GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    if (!beyond_framebuffer_)
        beyond_framebuffer_ = {device_, "field: light from beyond"};
    beyond_framebuffer_.attach_depth(depth.view());
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    gl::Defines defines = dimmed_defines();
    defines += shading;
    device_->UseProgram(programs_.get({"light/line.vert", "light/beyond.frag"}, defines).id());
    device_->Enable(GL_DEPTH_TEST);
    device_->DepthMask(GL_TRUE);
    device_->DepthFunc(GL_GREATER);  // what lies nearest to the lattice comes last
    for (std::size_t i = 0; i < ways.size(); ++i)
        for (int part = 0; part < 2; ++part) {
            beyond_framebuffer_.attach_color_layer(filling.beyond.view(),
                                                   2 * static_cast<int>(i) + part);
            const GLfloat far = 0;
            device_->ClearNamedFramebufferfv(beyond_framebuffer_.id(), GL_DEPTH, 0, &far);
            params_.tilt = kTilts.at(static_cast<std::size_t>(part) + 1);
            draw_lines(surfaces, drawn, 1, set_way(0, ways[i]), beyond_framebuffer_);
        }
    device_->Disable(GL_DEPTH_TEST);
    beyond_framebuffer_.detach_color();
    beyond_framebuffer_.attach_depth({});
    wait_for_drawing();
}

gl::Defines RadianceField::dimmed_defines() const
{
    const FieldMedium& medium = filling_->medium;
    gl::Defines defines = medium.defines;
    if (medium.dims)
        defines.emplace_back("kDims", "");
    if (medium.extinction != nullptr)
        defines.emplace_back("kMarched", "");
    return defines;
}

void RadianceField::light_surfaces(const gl::Defines& shading, const surface::SurfaceSet& surfaces)
{
    Filling& filling = *filling_;
    if (filling.medium.extinction != nullptr)
        filling.medium.extinction->bind(EXTINCTION_VOLUME_UNIT);
    if (!filling.beyond)
        draw_beyond(shading, surfaces);
    write_block();
    drawn_->faces.bind(FACES_UNIT);
    filling.materials.bind(FACE_MATERIALS_UNIT);
    bind_image(0, filling.face_light, GL_WRITE_ONLY, GL_RGBA16F);
    gl::Defines defines = dimmed_defines();
    defines += shading;
    if (filling.emitted) {
        defines.emplace_back("kEmits", "");
        filling.emitted.bind(FACE_LIGHT_UNIT);
    }
    dispatch("light/face_light.comp", defines, filling.lattice.count * glm::ivec3(1, 1, 6),
             kVolumeGroup);
}

gl::Defines RadianceField::bounce_defines() const
{
    const FieldMedium& medium = filling_->medium;
    gl::Defines defines = medium.defines;
    if (!medium.dims)
        defines.emplace_back("kClear", "");
    if (medium.dims && medium.marched)
        defines.emplace_back("kMarched", "");
    return defines;
}

Steps RadianceField::carry_bounced(int ways, int bands, const gl::Defines& defines,
                                   const gl::Texture& to)
{
    const Filling& filling = *filling_;
    const bool begins = begin_by_lamps(bands, to);
    for (const Batch& batch : batches(ways)) {
        set_batch(batch);
        (filling.marched ? filling.marched : filling.sigma_t).bind(FIELD_SIGMA_T_UNIT);
        filling.walls.bind(WALLS_UNIT);
        drawn_->faces.bind(FACES_UNIT);
        filling.face_light.bind(FACE_LIGHT_UNIT);
        filling.beyond.bind(BEYOND_UNIT);
        walk("light/bounce.comp", defines, batch.count);
        gather(bands, begins || batch.first > 0, Of::dimmed, filling.ways, to);
        if (co_await Pause{})
            bind_again();
    }
}

Steps RadianceField::bounce(int ways, int bands, const gl::Texture* alone, const gl::Texture* clear,
                            const gl::Texture* dimmed)
{
    Filling& filling = *filling_;
    filling.bounced_before_that = std::move(filling.bounced_before);
    filling.bounced_before = std::move(filling.bounced);
    filling.bounced = make("field: bounced", bands * bands);
    const gl::Defines defines = bounce_defines();
    co_await carry_bounced(ways, bands, defines, filling.bounced);
    if (alone != nullptr)
        finish(bands, filling.bounced, nullptr, nullptr, *alone);
    if (clear != nullptr)
        finish(bands, filling.bounced, &filling.clear, nullptr, *clear);
    if (dimmed != nullptr)
        finish(bands, filling.bounced, &filling.dimmed, nullptr, *dimmed);
}

void RadianceField::even_out(int bands, gl::Texture& light)
{
    gl::Texture other = make("field: light evened out", bands * bands);
    for (int axis = 0; axis < 3; ++axis) {
        light.bind(FIELD_LIGHT_UNIT);
        filling_->clearance.bind(FIELD_CROSSED_UNIT);
        bind_image(0, other, GL_WRITE_ONLY);
        dispatch_nodes("light/even_out.comp",
                       {{"kBands", fmt::format("{}", bands)}, {"kAxis", fmt::format("{}", axis)}});
        std::swap(light, other);
    }
}

Steps RadianceField::smooth(int ways, int bands, const FieldLight* light, const gl::Texture& clear,
                            const gl::Texture* dimmed)
{
    Filling& filling = *filling_;
    gl::Defines defines = bounce_defines();
    gl::Texture& sum = filling.bounced;
    const bool scatters = light != nullptr && light->scattered != nullptr;
    gl::Texture beyond, of_all, source;
    if (filling.sends_in || filling.lamps) {
        defines.emplace_back("kBeyond", "");
        beyond = make("field: from beyond and of lamps", bands * bands);
        if (filling.sends_in)
            co_await carry_bounced(ways, bands, defines, beyond);
        else
            begin_by_lamps(bands, beyond);
    }
    if (scatters) {
        of_all = make("field: of surfaces and media", bands * bands);
        bind_image(1, of_all, GL_WRITE_ONLY);
        defines.emplace_back("kScatters", "");
        set_batch({kNearWays, 0, kNearWays});
        source = spread({light->scattered, nullptr, light->at, light->bands}, kNearWays);
        source.bind(FIELD_SOURCE_UNIT);
    }
    defines.emplace_back("kBands", fmt::format("{}", bands));
    write_block();
    beyond.bind(FIELD_LIGHT_UNIT);
    (!of_all && filling.marched ? filling.marched : filling.sigma_t).bind(FIELD_SIGMA_T_UNIT);
    filling.face_light.bind(FACE_LIGHT_UNIT);
    filling.clearance.bind(FIELD_CROSSED_UNIT);
    bind_image(0, sum, GL_READ_WRITE);
    dispatch_nodes("light/face_gather.comp", defines);
    if (co_await Pause{})
        bind_again();
    even_out(bands, sum);
    if (of_all && dimmed != nullptr)
        even_out(bands, of_all);
    finish(bands, sum, &filling.clear, nullptr, clear);
    if (dimmed != nullptr)
        finish(bands, of_all ? of_all : sum, of_all ? &filling.of_world : &filling.dimmed, nullptr,
               *dimmed);
}

void RadianceField::take_over(const OtherLight& other, int bands, const gl::Texture& to)
{
    params_.other = other.at;
    write_block();
    other.light->bind(FIELD_LIGHT_UNIT);
    other.walls->bind(WALLS_UNIT);
    bind_image(0, to, GL_READ_WRITE);
    dispatch_nodes("light/field_other.comp",
                   {{"kBands", fmt::format("{}", std::min(bands, other.bands))}});
}

const gl::Texture& RadianceField::walls() const
{
    return filling_->walls;
}

const gl::Texture& RadianceField::sights() const
{
    return filling_->sights;
}

gl::Texture RadianceField::take_sights()
{
    return std::move(filling_->sights);
}

gl::Texture RadianceField::take_walls()
{
    return std::move(filling_->walls);
}

void RadianceField::sample_medium()
{
    Filling& filling = *filling_;
    const FieldMedium& medium = filling.medium;
    write_block();
    if (medium.scatters) {
        filling.sigma_t = make("field: extinction", 1);
        filling.albedo = make("field: albedo", 1);
        gl::Defines defines = medium.defines;
        if (medium.glows) {
            defines.emplace_back("kGlows", "");
            filling.emission = make("field: emission", 1);
            bind_image(2, filling.emission, GL_WRITE_ONLY);
        }
        if (drawn_->crossed) {
            defines.emplace_back("kSurfaces", "");
            drawn_->crossed.bind(FIELD_CROSSED_UNIT);
        }
        bind_image(0, filling.sigma_t, GL_WRITE_ONLY);
        bind_image(1, filling.albedo, GL_WRITE_ONLY);
        dispatch_nodes("light/field_medium.comp", defines);
        list_nodes();
    }
    if (!medium.dims || !medium.marched || medium.scatters_again ||
        (medium.scatters && !medium.closed))
        return;
    filling.marched = make("field: marched extinction", 1);
    gl::Defines defines = medium.defines;
    defines.emplace_back("kMarched", "");
    bind_image(0, filling.marched, GL_WRITE_ONLY);
    dispatch_nodes("light/field_medium.comp", defines);
}

std::vector<RadianceField::Batch> RadianceField::batches(int set) const
{
    std::vector<Batch> out;
    for (int first = 0; first < set; first += filling_->batch)
        out.push_back({set, first, std::min(filling_->batch, set - first)});
    return out;
}

void RadianceField::set_batch(const Batch& batch)
{
    const Filling::Ways& set = batch.set == kNearWays ? filling_->near : filling_->all;
    for (int k = 0; k < batch.count; ++k) {
        const auto i = static_cast<std::size_t>(batch.first + k);
        set_way(k, set.wi[i]);
        shared::FieldWay& way = params_.ways[k];
        way.entry = set.entry[i];
        way.solid_angle = static_cast<float>(set.ways[i].solid_angle);
        if (filling_->ends)
            way.beside = ways_beside(set.ways, set.ways[i].step, way.axis);
    }
    params_.first = batch.first;
    params_.count = batch.count;
    double in_plane = 0;
    for (const LatticeWay& way : set.ways)
        if (way.step.x == 0)
            in_plane += way.solid_angle / (4 * std::numbers::pi);
    params_.in_plane = static_cast<float>(in_plane);
    write_block();
    drawn_->crossed.bind(FIELD_CROSSED_UNIT);
}

void RadianceField::gather(int bands, bool adds, Of of, const gl::Texture& ways,
                           const gl::Texture& to, Nodes nodes, const gl::Texture* dimmed)
{
    gl::Defines defines = extinction_defines();
    defines.emplace_back("kBands", fmt::format("{}", bands));
    if (adds)
        defines.emplace_back("kAdds", "");
    if (of == Of::clear)
        defines.emplace_back("kClear", "");
    if (of == Of::clear || of == Of::dimmed)
        defines.emplace_back("kWorld", "");
    if (of == Of::means)
        add_taken(defines);
    if (of == Of::clear && filling_->sky_shares != nullptr) {
        defines.emplace_back("kShares", "");
        filling_->sky_shares->bind(FIELD_EMISSION_UNIT);
    }
    add_ways(defines);
    ways.bind(FIELD_WAYS_UNIT);
    bind_image(0, to, GL_READ_WRITE);
    if (dimmed != nullptr) {
        defines.emplace_back("kDimmed", "");
        bind_image(1, *dimmed, GL_READ_WRITE);
    }
    dispatch_at(nodes, "light/field_gather.comp", defines);
}

void RadianceField::find_taken()
{
    Filling& filling = *filling_;
    const bool colored = filling.medium.colored;
    if (filling.medium.mixed_g)
        return;
    filling.taken =
        make("field: what ways count", colored ? FIELD_TAKEN_OF_CELL + 1 : FIELD_TAKEN / 4);
    filling.sigma_t.bind(FIELD_SIGMA_T_UNIT);
    bind_image(0, filling.taken, GL_WRITE_ONLY);
    dispatch_listed("light/field_taken.comp", extinction_defines());
}

void RadianceField::add_taken(gl::Defines& defines) const
{
    if (!filling_->taken)
        return;
    defines.emplace_back("kTaken", "");
    filling_->taken.bind(FIELD_SIGMA_T_UNIT);
}

void RadianceField::walk(const char* file, const gl::Defines& defines, int ways)
{
    const glm::ivec3 count = filling_->lattice.count;
    const int across = std::max({count.x, count.y, count.z});
    bind_image(0, filling_->ways, GL_WRITE_ONLY, GL_RG32UI);
    bind_image(1, filling_->light_ways, GL_WRITE_ONLY, light_format());
    dispatch(file, defines, {across, across, ways}, kChainGroup);
}

void RadianceField::carry_world(const Batch& batch, bool means)
{
    const FieldMedium& medium = filling_->medium;
    gl::Defines defines = medium.defines;
    const auto add = [&](bool asked, const char* name) {
        if (asked)
            defines.emplace_back(name, "");
    };
    add(!medium.dims, "kClear");
    // What one way takes from the world's light is what it gives of light that is scattered: both
    // are to be dimmed alike.
    const bool alike = medium.scatters_again;
    add(medium.dims && (medium.marched || alike), "kMarched");
    add(medium.dims && medium.closed && !alike, "kClosed");
    add(medium.dims && medium.amid && alike, "kAmid");
    add(static_cast<bool>(drawn_->crossed), "kSurfaces");
    add(means, "kMeans");
    add(means && !medium.mixed_g, "kTaken");
    add(alike && filling_->ends, "kEnds");
    add(alike && filling_->ends && !means, "kLooked");
    add(filling_->sky_shares != nullptr, "kShares");
    set_batch(batch);
    if (filling_->sky_shares != nullptr)
        filling_->sky_shares->bind(FIELD_EMISSION_UNIT);
    (filling_->marched && !alike ? filling_->marched : filling_->sigma_t).bind(FIELD_SIGMA_T_UNIT);
    filling_->walls.bind(WALLS_UNIT);
    walk("light/world.comp", defines, batch.count);
}

Steps RadianceField::add(const FieldLight& light, int bands, const gl::Texture& to)
{
    if (light.scattered == nullptr)
        co_return;
    if (light.along_rays) {
        co_await add_along_rays(light, bands, to);
        co_return;
    }
    for (const Batch& batch : batches(light.ways)) {
        set_batch(batch);
        const gl::Texture source =
            spread({light.scattered, nullptr, light.at, light.bands}, batch.count);
        sweep({.source = &source});
        gather(bands, true, Of::field, filling_->light_ways, to, Nodes::looked_up);
        if (co_await Pause{})
            bind_again();
    }
}

Steps RadianceField::add_along_rays(const FieldLight& light, int bands, const gl::Texture& to)
{
    Filling& filling = *filling_;
    if (!filling.clearance)
        find_clearance();
    set_batch({kNearWays, 0, kNearWays});
    const gl::Texture source = spread({light.scattered, nullptr, light.at, light.bands}, kNearWays);
    source.bind(FIELD_SOURCE_UNIT);
    filling.sigma_t.bind(FIELD_SIGMA_T_UNIT);
    filling.clearance.bind(FIELD_CROSSED_UNIT);
    bind_image(0, to, GL_READ_WRITE);
    dispatch_at(Nodes::looked_up, "light/media_gather.comp",
                {{"kBands", fmt::format("{}", bands)}});
    drawn_->crossed.bind(FIELD_CROSSED_UNIT);
    if (co_await Pause{})
        bind_again();
}

gl::Texture RadianceField::spread(const OtherLight& light, int ways, Nodes nodes)
{
    params_.other = light.at;
    write_block();
    gl::Texture source = make_sources(ways);
    light.light->bind(FIELD_LIGHT_UNIT);
    bind_image(0, source, GL_WRITE_ONLY, light_format());
    gl::Defines defines{{"kBands", fmt::format("{}", light.bands)}};
    add_ways(defines);
    dispatch_at(nodes, "light/field_spread.comp", defines);
    return source;
}

void RadianceField::add_ways(gl::Defines& defines) const
{
    if (params_.count == kNearWays || params_.count == kAllWays)
        defines.emplace_back("kWays", fmt::format("{}", params_.count));
}

Steps RadianceField::fill_world(int ways, int bands, const gl::Texture* clear,
                                const gl::Texture* dimmed, const FieldLight* light)
{
    const auto made = [&](const gl::Texture* to, const char* label) {
        return to != nullptr ? make(label, bands * bands) : gl::Texture();
    };
    gl::Texture &of_clear = filling_->clear = made(clear, "field: clear"),
                &of_dimmed = filling_->dimmed = made(dimmed, "field: dimmed");
    if (of_dimmed && !of_clear)
        clear_unlisted(of_dimmed);
    for (const Batch& batch : batches(ways)) {
        carry_world(batch, false);
        if (of_clear)
            gather(bands, batch.first > 0, Of::clear, filling_->ways, of_clear, Nodes::looked_up,
                   of_dimmed ? &of_dimmed : nullptr);
        else if (of_dimmed)
            gather(bands, batch.first > 0, Of::dimmed, filling_->ways, of_dimmed, Nodes::listed);
        if (co_await Pause{})
            bind_again();
    }
    if (of_dimmed && light != nullptr)
        co_await add(*light, bands, of_dimmed);
    if (of_clear)
        finish(bands, of_clear, nullptr, nullptr, *clear, Nodes::looked_up);
    if (of_dimmed)
        finish(bands, of_dimmed, nullptr, nullptr, *dimmed,
               of_clear ? Nodes::looked_up : Nodes::listed);
}

Steps RadianceField::add_light(int bands, const FieldLight& light, const gl::Texture& dimmed,
                               int taken_back)
{
    // Light that was added before is to be added anew.
    Filling& filling = *filling_;
    const bool again = static_cast<bool>(filling.of_world);
    if (!again)
        filling.of_world = make("field: dimmed, of the world", bands * bands);
    const gl::Texture &from = again ? filling.of_world : filling.dimmed,
                      &to = again ? filling.dimmed : filling.of_world;
    copy(from, to);
    co_await add(light, bands, filling_->dimmed);
    const std::array<const gl::Texture*, 3> turns{&filling.bounced, &filling.bounced_before,
                                                  &filling.bounced_before_that};
    const gl::Texture& bounced = *turns.at(static_cast<std::size_t>(taken_back));
    if (bounced)
        finish(bands, bounced, &filling.dimmed, nullptr, dimmed);
    else
        finish(bands, filling.dimmed, nullptr, nullptr, dimmed);
}

gl::Defines RadianceField::extinction_defines() const
{
    return {{"extinction_t", filling_->medium.colored ? "vec3" : "float"}};
}

void RadianceField::sweep(const Sweep& what)
{
    const Filling& filling = *filling_;
    gl::Defines defines = extinction_defines();
    const auto add = [&](bool asked, const char* name) {
        if (asked)
            defines.emplace_back(name, "");
    };
    add(what.emits, "kEmits");
    add(what.source != nullptr, "kScatters");
    add(what.comes != nullptr, "kComes");
    add(what.means, "kMeans");
    add(what.means && !filling.medium.mixed_g, "kTaken");
    add(filling.ends, "kEnds");
    add(filling.ends && !what.means && what.looked, "kLooked");
    add(static_cast<bool>(drawn_->crossed), "kSurfaces");
    add(drawn_->crossed && params_.count == kNearWays && params_.first == 0, "kNear");
    filling.emission.bind(FIELD_EMISSION_UNIT);
    filling.sigma_t.bind(FIELD_SIGMA_T_UNIT);
    if (what.source != nullptr)
        what.source->bind(FIELD_SOURCE_UNIT);
    if (what.comes != nullptr)
        what.comes->bind(FIELD_LIGHT_UNIT);
    walk("light/field_sweep.comp", defines, params_.count);
}

void RadianceField::finish(int bands, const gl::Texture& light, const gl::Texture* world,
                           const gl::Texture* total, const gl::Texture& to, Nodes nodes, bool holed)
{
    gl::Defines defines{{"kBands", fmt::format("{}", bands)}};
    if (nodes == Nodes::listed)
        clear_unlisted(to);
    if (nodes == Nodes::looked_up && filling_->looked_up) {
        const std::array<GLfloat, 4> as_inside_of_surfaces{};
        to.clear(GL_RGBA, GL_FLOAT, as_inside_of_surfaces.data());
    }
    if (world != nullptr) {
        defines.emplace_back("kWorld", "");
        world->bind(FIELD_WORLD_UNIT);
    }
    if (holed)
        defines.emplace_back("kHole", "");
    if (total != nullptr) {
        defines.emplace_back("kField", "");
        total->bind(FIELD_ORDER_UNIT);
    }
    light.bind(FIELD_LIGHT_UNIT);
    bind_image(0, to, GL_WRITE_ONLY, GL_RGBA16F);
    dispatch_at(nodes, "light/field_finish.comp", defines);
}

Steps RadianceField::fill(int ways, int bands, FieldOrders orders, FieldInput from, FieldOutput to)
{
    using From = OrdersStart::From;
    const OrdersStart& start = from.start;
    const bool has_arrived = start.from == From::arrived || start.from == From::arrived_here;
    guess_ = {};
    if (start.from != From::arrived_here) {
        sums_ = {};
        orders_ = 0;
    }
    const FieldMedium& medium = filling_->medium;
    const gl::Texture first = make("field: what comes first", bands * bands);
    clear_unlisted(first);
    const Batch near{kNearWays, 0, kNearWays};
    set_batch(near);
    find_taken();
    gl::Defines direct = medium.defines;
    direct.emplace_back("kBands", fmt::format("{}", bands));
    if (medium.dims)
        direct.emplace_back("kDims", "");
    if (filling_->ends)
        direct.emplace_back("kEnds", "");
    if (medium.left_out.x < medium.left_out.y)
        direct.emplace_back("kLeavesOut", "");
    if (medium.extinction != nullptr) {
        direct.emplace_back("kMarched", "");
        medium.extinction->bind(EXTINCTION_VOLUME_UNIT);
    }
    add_taken(direct);
    bind_image(0, first, GL_WRITE_ONLY);
    dispatch_listed("light/field_direct.comp", direct);
    if (co_await Pause{})
        bind_again();
    gl::Texture direct_alone;
    if (has_arrived && orders.count > 0) {
        direct_alone = make("field: straight from lights", bands * bands);
        copy(first, direct_alone);
    }
    if (medium.world != nullptr) {
        carry_world(near, true);
        gather(bands, true, Of::means, filling_->light_ways, first, Nodes::listed);
    }
    set_batch(near);
    if (medium.glows || from.beyond != nullptr) {
        const gl::Texture comes = come_in(from.beyond, kNearWays);
        sweep({.emits = medium.glows, .comes = comes ? &comes : nullptr, .means = true});
        gather(bands, true, Of::means, filling_->light_ways, first, Nodes::listed);
    }
    if (from.bounced != nullptr)
        take_over(*from.bounced, bands, first);
    gl::Texture source, scattered;
    if (orders.count > 0)
        co_await scatter(bands, orders, first, direct_alone, start, source);
    if (source && (to.scattered != nullptr || ways != kNearWays)) {
        scattered = make("field: what is scattered", bands * bands);
        const std::array<GLfloat, 4> none{};
        scattered.clear(GL_RGBA, GL_FLOAT, none.data());
        gather(bands, false, Of::field, source, scattered, Nodes::listed);
    }
    shared::LatticeParams own = filling_->lattice.params;
    own.layers = static_cast<float>(bands * bands);
    own.inverse_size.z /= own.layers;
    // What is looked up is the light at the nodes, not the means that went from order to order.
    const gl::Texture light = make("field: light", bands * bands);
    clear_unlisted(light);
    for (const Batch& batch : batches(ways)) {
        set_batch(batch);
        gl::Texture spread_out;
        if (source && ways != kNearWays)
            spread_out = spread({&scattered, nullptr, own, bands}, batch.count);
        const gl::Texture comes = come_in(from.beyond, batch.count);
        sweep({.emits = medium.glows,
               .source = spread_out ? &spread_out
                         : source   ? &source
                                    : nullptr,
               .comes = comes ? &comes : nullptr,
               .looked = true});
        gather(bands, batch.first > 0, Of::field, filling_->light_ways, light, Nodes::listed);
        if (co_await Pause{})
            bind_again();
    }
    if (to.of_media != nullptr)
        finish(bands, light, nullptr, &first, *to.of_media, Nodes::listed, true);
    if (from.bounced != nullptr)
        take_over(*from.bounced, bands, light);
    finish(bands, light, from.world, &first, to.field, Nodes::listed);
    if (to.scattered != nullptr)
        *to.scattered = std::move(scattered);
}

gl::Texture RadianceField::come_in(const OtherLight* beyond, int ways)
{
    return beyond != nullptr ? spread(*beyond, ways, Nodes::all) : gl::Texture();
}

void RadianceField::make_whole(int bands, const gl::Texture& scattered)
{
    if (filling_->medium.straight_on == 0)
        return;
    filling_->albedo.bind(FIELD_ALBEDO_UNIT);
    bind_image(0, scattered, GL_READ_WRITE);
    dispatch_listed("light/field_whole.comp", {{"kBands", fmt::format("{}", bands)}});
}

gl::Texture RadianceField::own_light()
{
    gl::Texture own = make("field: own light", 1);
    gl::Defines defines = extinction_defines();
    if (drawn_->crossed)
        defines.emplace_back("kSurfaces", "");
    filling_->sigma_t.bind(FIELD_SIGMA_T_UNIT);
    bind_image(0, own, GL_WRITE_ONLY);
    dispatch_listed("light/field_own.comp", defines);
    return own;
}

void RadianceField::weigh(const gl::Texture& kept, int orders)
{
    const int slices_z = filling_->lattice.count.z, pairs = orders * (orders + 1) / 2 + 1;
    const gl::Texture slices = gl::Texture::make_3d(
        device_, "field: orders' products", {slices_z, pairs, 1}, GL_RGBA32F, gl::Filter::nearest);
    kept.bind(FIELD_SOURCE_UNIT);
    filling_->sigma_t.bind(FIELD_SIGMA_T_UNIT);
    filling_->albedo.bind(FIELD_ALBEDO_UNIT);
    bind_image(0, slices, GL_WRITE_ONLY);
    dispatch("light/field_rest.comp", {}, {64, pairs, slices_z}, {64, 1, 1});
    slices.bind(FIELD_LIGHT_UNIT);
    bind_image(0, guess_, GL_WRITE_ONLY);
    dispatch("light/field_rest.comp", {{"kFinish", ""}}, {64, 1, 1}, {64, 1, 1});
}

Steps RadianceField::scatter(int bands, FieldOrders orders, const gl::Texture& first,
                             const gl::Texture& direct, OrdersStart start, gl::Texture& source)
{
    using From = OrdersStart::From;
    const bool has_arrived = start.from == From::arrived || start.from == From::arrived_here;
    const bool notes = start.from != From::arrived_here;
    const Filling& filling = *filling_;
    const int slices_z = filling.lattice.count.z;
    const bool guesses = orders.cycles > 0, ahead = guesses && orders.coarse_first;
    // Of those asked for, the last is what comes of the light that is gathered for good.
    const int steps = guesses ? orders.count : orders.count - 1;
    const int count = 1 + steps * (guesses ? orders.cycles : 1);
    source = make_sources(kNearWays);
    const gl::Texture mean =
        gl::Texture::make_3d(device_, "field: mean radiance", filling.lattice.count, light_format(),
                             gl::Filter::nearest);
    const GLuint dark = 0;
    mean.clear(GL_RED_INTEGER, GL_UNSIGNED_INT, &dark);
    gl::Texture slices, kept, own;
    if (notes) {
        orders_ = count;
        slices = gl::Texture::make_3d(device_, "field: slices' sums", {2 * slices_z, count, 1},
                                      GL_RGBA32F, gl::Filter::nearest);
        sums_ = gl::Texture::make_3d(device_, "field: sums", {FIELD_MOST_ORDERS + 1, 1, 1},
                                     GL_RGBA32F, gl::Filter::nearest);
    }
    if (guesses) {
        const std::array<GLfloat, 4> none{};
        kept = make("field: orders", 2 * steps);
        kept.clear(GL_RGBA, GL_FLOAT, none.data());
        guess_ =
            gl::Texture::make_3d(device_, "field: weights of orders", {FIELD_KEPT_ORDERS + 1, 1, 1},
                                 GL_RGBA32F, gl::Filter::nearest);
        params_.slots = steps;
    }
    if (ahead)
        own = own_light();
    const auto pass_of = [&](const gl::Texture& light, const gl::Defines& what,
                             const gl::Texture& ways) {
        gl::Defines defines = extinction_defines();
        defines.emplace_back("kBands", fmt::format("{}", bands));
        for (const auto& [name, value] : what.entries())
            defines.emplace_back(name, value);
        if (guesses)
            defines.emplace_back("kKeeps", "");
        add_taken(defines);
        light.bind(FIELD_LIGHT_UNIT);
        filling.albedo.bind(FIELD_ALBEDO_UNIT);
        ways.bind(FIELD_WAYS_UNIT);
        guess_.bind(FIELD_SUMS_UNIT);
        own.bind(FIELD_EMISSION_UNIT);
        bind_image(0, source, GL_WRITE_ONLY, light_format());
        bind_image(1, mean, GL_WRITE_ONLY, light_format());
        if (kept)
            bind_image(2, kept, GL_READ_WRITE);
        dispatch_listed("light/field_scatter.comp", defines);
    };
    const auto pass = [&](const gl::Defines& what, const gl::Texture& ways) {
        pass_of(first, what, ways);
    };
    const auto sum = [&](int order) {
        if (!notes)
            return;
        params_.order = order;
        write_block();
        mean.bind(FIELD_WAYS_UNIT);
        filling.sigma_t.bind(FIELD_SIGMA_T_UNIT);
        filling.albedo.bind(FIELD_ALBEDO_UNIT);
        bind_image(0, slices, GL_WRITE_ONLY);
        dispatch("light/field_sum.comp", {}, {64, 1, slices_z}, {64, 1, 1});
    };
    gl::Defines of_first{{"kFirst", ""}};
    if (has_arrived) {
        params_.other = start.light.at;
        write_block();
        start.light.light->bind(FIELD_ORDER_UNIT);
        pass_of(direct, {{"kFirst", ""}, {"kBefore", ""}}, filling.light_ways);
    }
    if (start.from != From::lights)  // that is scattered in its place
        of_first.emplace_back("kMean", "");
    pass(of_first, filling.light_ways);
    sum(0);
    if (start.from == From::scattered) {
        source = spread(start.light, kNearWays);
        if (guesses)
            pass({{"kOwn", ""}}, source);
    }
    for (int order = 1; order < count; ++order) {
        params_.slot = guesses ? (order - 1) % steps : 0;
        const bool ends = guesses && params_.slot + 1 == steps;
        gl::Defines defines;
        if (ends)
            defines.emplace_back("kMean", "");
        if (ahead)
            defines.emplace_back("kAhead", "");
        write_block();
        sweep({.source = &source, .means = true});
        pass(defines, filling.light_ways);
        sum(order);
        if (ends) {
            weigh(kept, steps);
            pass({{"kTail", ""}}, filling.light_ways);
        }
        if (co_await Pause{})
            bind_again();
    }
    if (!notes)
        co_return;
    slices.bind(FIELD_LIGHT_UNIT);
    bind_image(0, sums_, GL_WRITE_ONLY);
    dispatch("light/field_sum.comp", {{"kFinish", ""}}, {64, 1, 1}, {64, 1, 1});
}

std::vector<glm::vec3> RadianceField::sums() const
{
    std::vector<glm::vec3> out;
    if (!sums_)
        return out;
    const std::vector<float> values = sums_.read(3);
    for (std::size_t i = 0; i < static_cast<std::size_t>(orders_); ++i)
        out.emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    return out;
}

std::optional<float> RadianceField::left_over() const
{
    if (!guess_)
        return {};
    const std::vector<float> values = guess_.read(3);
    constexpr std::size_t kLeft = 3 * FIELD_KEPT_ORDERS;
    return std::max({values[kLeft], values[kLeft + 1], values[kLeft + 2]});
}

}  // namespace fumarole::light
