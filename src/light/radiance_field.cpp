#include "light/radiance_field.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <fmt/format.h>
#include <glm/gtc/matrix_transform.hpp>
#include <numbers>

#include "light/world_light.h"

namespace fumarole::light {

namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kLevels = 4, kAround = 8;  ///< directions: of z, and around it

struct Ordinate {
    glm::dvec3 wi{0};
    double solid_angle = 0;
};

std::vector<Ordinate> ordinates()
{
    // Gauss and Legendre's four points in z: exact to z^7. Eight around: to the seventh harmonic.
    constexpr std::array<double, kLevels> kZ{-0.861136311594053, -0.339981043584856,
                                             0.339981043584856, 0.861136311594053};
    constexpr std::array<double, kLevels> kWeight{0.347854845137454, 0.652145154862546,
                                                  0.652145154862546, 0.347854845137454};
    std::vector<Ordinate> all;
    for (int i = 0; i < kLevels; ++i) {
        const auto level = static_cast<std::size_t>(i);
        const double r = std::sqrt(1 - kZ[level] * kZ[level]);
        for (int j = 0; j < kAround; ++j) {
            // Levels are turned against each other, so that no plane has many of them.
            const double phi = 2 * kPi * (j + 0.25 + 0.5 * (i % 2)) / kAround;
            all.push_back({{r * std::cos(phi), r * std::sin(phi), kZ[level]},
                           kWeight[level] * 2 * kPi / kAround});
        }
    }
    return all;
}

/// The world's radiance from each of them: what comes from directions that are nearest to it.
std::vector<glm::vec3> entries(const World* world)
{
    const std::vector<Ordinate> all = ordinates();
    std::vector<glm::vec3> entry(all.size(), glm::vec3(0));
    if (world == nullptr)
        return entry;
    if (world->environment == nullptr)
        return std::vector<glm::vec3>(all.size(), world->radiance);
    for (const WorldCell& cell : world_cells(*world, MAX_WORLD_DIRECTIONS)) {
        const auto nearest =
            std::max_element(all.begin(), all.end(), [&](const Ordinate& a, const Ordinate& b) {
                return glm::dot(a.wi, cell.wi) < glm::dot(b.wi, cell.wi);
            });
        entry[static_cast<std::size_t>(nearest - all.begin())] +=
            glm::vec3(cell.power / nearest->solid_angle);
    }
    return entry;
}

glm::dvec3 to_axes(int axis, glm::dvec3 q)
{
    return {q[axis], q[(axis + 1) % 3], q[(axis + 2) % 3]};
}

/// How a direction's columns go through a lattice. columns: that it takes along each edge.
shared::FieldDirection columns_of(const Ordinate& ordinate, const FieldLattice& lattice,
                                  int& columns, int& slices)
{
    const glm::dvec3 d = glm::dmat3(lattice.node_from_eye) * -ordinate.wi;  // nodes a metre
    const glm::dvec3 size = glm::abs(d);
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const glm::dvec3 way = to_axes(axis, d) / size[axis];
    const glm::dvec3 last = to_axes(axis, glm::dvec3(lattice.count - 1));
    shared::FieldDirection out{};
    out.wi = glm::vec3(ordinate.wi);
    out.solid_angle = static_cast<float>(ordinate.solid_angle);
    out.slope = {way.y, way.z};
    out.axis = axis;
    out.forward = way.x > 0 ? 1.0f : -1.0f;
    out.metres = static_cast<float>(1 / size[axis]);
    slices = static_cast<int>(last.x) + 1;
    columns = 0;
    for (int i = 0; i < 2; ++i) {
        const double slope = way[i + 1], shift = std::ceil(std::abs(slope) * last.x);
        out.first[i] = static_cast<float>(slope > 0 ? -shift : 0);
        columns = std::max(columns, static_cast<int>(last[i + 1] + shift) + 2);
    }
    return out;
}

constexpr glm::ivec3 kVolumeGroup(VOLUME_GROUP);

/// Of 32 ways between slices each.
int words(int slices)
{
    return (slices + 31) / 32;
}

/// Clip space in which a column is a pixel of `columns` and z grows from slice to slice, and holds
/// all that may hide the world from the first.
glm::dmat4 clip_from_node(const shared::FieldDirection& d, const FieldLattice& lattice, int columns)
{
    const int along = d.axis;
    const double last = lattice.count[along] - 1;
    glm::dmat4 columns_from_node(0.0);  // x, y: the column, z: the slice
    columns_from_node[along][2] = d.forward;
    columns_from_node[3][2] = d.forward > 0 ? 0 : last;
    for (int i = 0; i < 2; ++i) {
        const double slope = d.slope[i];
        columns_from_node[(along + 1 + i) % 3][i] = 1;
        columns_from_node[along][i] = -slope * d.forward;
        columns_from_node[3][i] = -slope * columns_from_node[3][2] - d.first[i];
    }
    columns_from_node[3][3] = 1;
    return glm::translate(glm::dmat4(1.0), glm::dvec3(-1, -1, 0)) *
           glm::scale(glm::dmat4(1.0), glm::dvec3(2.0 / columns, 2.0 / columns, 1e-6)) *
           glm::translate(glm::dmat4(1.0), glm::dvec3(0.5, 0.5, 0)) * columns_from_node;
}

}  // namespace

/// What is there while the field is filled.
struct RadianceField::Volumes {
    const FieldLattice& lattice;
    int bands;
    std::vector<glm::vec3> entry;  ///< the world's radiance from each direction
    gl::Texture sigma_t, albedo, emission;
    gl::Texture light, next, total;  ///< coefficients: of an order, of the next, of all so far
    gl::Texture source, columns;
    gl::Texture crossed;  ///< ways that surfaces cross
};

/// What is carried through the lattice at once.
struct RadianceField::Carried {
    bool enters = false;                     ///< the world's light
    bool emits = false;                      ///< what the media emit
    const gl::Texture* scattered = nullptr;  ///< coefficients of what they scatter
    const gl::Texture* tail = nullptr;       ///< and of the last order of that, with those after it
    bool means = false;                      ///< gathered are means, to be scattered
    const gl::Texture* total = nullptr;      ///< summed up there too
};

void RadianceField::dispatch(const char* file, const gl::Defines& defines, glm::ivec3 threads,
                             glm::ivec3 group) const
{
    device_->UseProgram(programs_.get({file}, defines).id());
    const glm::uvec3 groups((threads + group - 1) / group);
    device_->DispatchCompute(groups.x, groups.y, groups.z);
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
}

gl::Texture RadianceField::draw(const FieldLattice& lattice, const surface::SurfaceSet& surfaces)
{
    if (surfaces.empty())
        return {};
    const std::vector<Ordinate> all = ordinates();
    const int layers = static_cast<int>(all.size()) * words(params_.slices);
    gl::Texture crossed =
        gl::Texture::make_3d(device_, "field: surfaces", {params_.columns, params_.columns, layers},
                             GL_R32UI, gl::Filter::nearest);
    const GLuint none = 0;
    device_->ClearTexImage(crossed.id(), 0, GL_RED_INTEGER, GL_UNSIGNED_INT, &none);
    if (!framebuffer_)
        framebuffer_ = {device_, "field: surfaces"};
    const glm::ivec2 size(params_.columns);
    framebuffer_.set_empty(size);
    framebuffer_.bind(size);
    device_->UseProgram(programs_.get({"pass/surface.vert", "light/crossed.frag"}, {}).id());
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    device_->BindBufferBase(GL_UNIFORM_BUFFER, FIELD_BLOCK, block_.id());
    device_->BindImageTexture(0, crossed.id(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_R32UI);
    int columns = 0, slices = 0;
    for (std::size_t i = 0; i < all.size(); ++i) {
        params_.directions[0] = columns_of(all[i], lattice, columns, slices);
        params_.directions[0].first_word = static_cast<int>(i) * words(params_.slices);
        block_.write(params_);
        const glm::dmat4 clip =
            clip_from_node(params_.directions[0], lattice, params_.columns) * lattice.node_from_eye;
        for (const auto& instance : surfaces.instances()) {
            const glm::dmat4 eye_from_object =
                glm::translate(glm::dmat4(1.0), -lattice.eye) * instance.world_from_object;
            shared::DrawParams params{};
            params.clip_from_object = glm::mat4(clip * eye_from_object);
            params.world_from_object = glm::mat4(eye_from_object);
            draw_block_.write(params);
            surfaces.draw(instance);
        }
    }
    // As in LightVolumes::draw_world: llvmpipe wants a barrier between a draw and a compute shader.
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
    return crossed;
}

void RadianceField::carry(const Volumes& volumes, const Carried& carried, const gl::Texture& to,
                          bool adds)
{
    const FieldLattice& lattice = volumes.lattice;
    const gl::Defines bands{{"kBands", fmt::format("{}", volumes.bands)}};
    const std::vector<Ordinate> all = ordinates();
    for (std::size_t first = 0; first < all.size(); first += FIELD_BATCH) {
        const int count = std::min(FIELD_BATCH, static_cast<int>(all.size() - first));
        int columns = 0;
        for (int k = 0; k < count; ++k) {
            int own_columns = 0, slices = 0;
            const std::size_t i = first + static_cast<std::size_t>(k);
            params_.directions[k] = columns_of(all[i], lattice, own_columns, slices);
            params_.directions[k].first_word = static_cast<int>(i) * words(params_.slices);
            params_.directions[k].entry = volumes.entry[i];
            columns = std::max(columns, own_columns);
        }
        params_.count = count;
        block_.write(params_);
        device_->BindBufferBase(GL_UNIFORM_BUFFER, FIELD_BLOCK, block_.id());

        const auto image = [&](GLuint unit, const gl::Texture& texture, GLenum access) {
            device_->BindImageTexture(unit, texture.id(), 0, GL_TRUE, 0, access, GL_RGBA32F);
        };
        gl::Defines sweep;
        const auto add = [&](bool asked, const char* name) {
            if (asked)
                sweep.emplace_back(name, "");
        };
        add(carried.enters, "kEnters");
        add(carried.emits, "kEmits");
        add(carried.scattered != nullptr, "kScatters");
        add(carried.means, "kMeans");
        add(static_cast<bool>(volumes.crossed), "kSurfaces");
        if (carried.scattered != nullptr) {
            gl::Defines scatter = bands;
            if (carried.tail != nullptr) {
                scatter.emplace_back("kTail", "");
                carried.tail->bind(FIELD_ORDER_UNIT);
                sums_.bind(FIELD_SUMS_UNIT);
            }
            carried.scattered->bind(FIELD_LIGHT_UNIT);
            volumes.albedo.bind(FIELD_ALBEDO_UNIT);
            image(0, volumes.source, GL_WRITE_ONLY);
            dispatch("light/field_scatter.comp", scatter, lattice.count, kVolumeGroup);
        }
        volumes.source.bind(FIELD_SOURCE_UNIT);
        volumes.emission.bind(FIELD_EMISSION_UNIT);
        volumes.crossed.bind(FIELD_CROSSED_UNIT);
        volumes.sigma_t.bind(FIELD_SIGMA_T_UNIT);
        image(0, volumes.columns, GL_WRITE_ONLY);
        dispatch("light/field_sweep.comp", sweep, {columns, columns, count}, {8, 8, 1});

        gl::Defines gather = bands;
        if (first == 0 && !adds)
            gather.emplace_back("kFirstBatch", "");
        if (carried.total != nullptr) {
            gather.emplace_back("kTotal", "");
            image(1, *carried.total, GL_READ_WRITE);
        }
        volumes.columns.bind(FIELD_COLUMNS_UNIT);
        image(0, to, GL_READ_WRITE);
        dispatch("light/field_gather.comp", gather, lattice.count, kVolumeGroup);
    }
}

void RadianceField::fill(const FieldLattice& lattice, const FieldMedium& medium,
                         const surface::SurfaceSet& surfaces, int bands, FieldOrders orders,
                         const gl::Texture* world, const gl::Texture& field)
{
    const auto make = [&](const char* label, int layers) {
        return gl::Texture::make_3d(device_, label, lattice.count * glm::ivec3(1, 1, layers),
                                    GL_RGBA32F, gl::Filter::linear);
    };
    const int layers = bands * bands;
    Volumes volumes{.lattice = lattice,
                    .bands = bands,
                    .entry = entries(medium.world),
                    .sigma_t = make("field: extinction", 1),
                    .albedo = make("field: albedo", 1),
                    .emission = {},
                    .light = make("field: an order", layers),
                    .next = make("field: the next", layers),
                    .total = make("field: all orders", layers),
                    .source = make("field: source", FIELD_BATCH),
                    .columns = {},
                    .crossed = {}};
    if (medium.glows)
        volumes.emission = make("field: emission", 1);
    params_ = {};
    params_.nodes = lattice.params;
    params_.albedo = medium.albedo;
    for (const Ordinate& ordinate : ordinates()) {
        int columns = 0, slices = 0;
        columns_of(ordinate, lattice, columns, slices);
        params_.columns = std::max(params_.columns, columns);
        params_.slices = std::max(params_.slices, slices);
    }
    volumes.columns = gl::Texture::make_3d(
        device_, "field: columns", {params_.columns, params_.columns, params_.slices * FIELD_BATCH},
        GL_RGBA32F, gl::Filter::linear);
    sums_ = gl::Texture::make_3d(device_, "field: sums", {FIELD_MOST_ORDERS + 1, 1, 1}, GL_RGBA32F,
                                 gl::Filter::nearest);
    orders_ = orders.count;
    volumes.crossed = draw(lattice, surfaces);
    block_.write(params_);
    device_->BindBufferBase(GL_UNIFORM_BUFFER, FIELD_BLOCK, block_.id());
    const auto image = [&](GLuint unit, const gl::Texture& texture, GLenum access,
                           GLenum format = GL_RGBA32F) {
        device_->BindImageTexture(unit, texture.id(), 0, GL_TRUE, 0, access, format);
    };

    gl::Defines of_medium = medium.defines;
    if (medium.glows) {
        of_medium.emplace_back("kGlows", "");
        image(2, volumes.emission, GL_WRITE_ONLY);
    }
    image(0, volumes.sigma_t, GL_WRITE_ONLY);
    image(1, volumes.albedo, GL_WRITE_ONLY);
    dispatch("light/field_medium.comp", of_medium, lattice.count, kVolumeGroup);

    gl::Defines direct = medium.defines;
    direct.emplace_back("kBands", fmt::format("{}", bands));
    if (medium.dims)
        direct.emplace_back("kDims", "");
    if (medium.extinction != nullptr) {
        direct.emplace_back("kMarched", "");
        medium.extinction->bind(EXTINCTION_VOLUME_UNIT);
    }
    image(0, volumes.light, GL_WRITE_ONLY);
    dispatch("light/field_direct.comp", direct, lattice.count, kVolumeGroup);

    const bool enters = medium.world != nullptr;
    if (enters || medium.glows)
        carry(volumes, {.enters = enters, .emits = medium.glows, .means = true}, volumes.light,
              true);
    const glm::ivec3 size = volumes.light.size();
    device_->CopyImageSubData(volumes.light.id(), GL_TEXTURE_3D, 0, 0, 0, 0, volumes.total.id(),
                              GL_TEXTURE_3D, 0, 0, 0, 0, size.x, size.y, size.z);
    const auto sum = [&](int order) {
        params_.order = order;
        block_.write(params_);
        device_->BindBufferBase(GL_UNIFORM_BUFFER, FIELD_BLOCK, block_.id());
        volumes.light.bind(FIELD_LIGHT_UNIT);
        volumes.sigma_t.bind(FIELD_SIGMA_T_UNIT);
        volumes.albedo.bind(FIELD_ALBEDO_UNIT);
        image(0, sums_, GL_WRITE_ONLY);
        dispatch("light/field_sum.comp", {}, {1, 1, 1}, {1, 1, 1});
    };
    sum(0);
    for (int order = 1; order < orders.count; ++order) {
        carry(volumes, {.scattered = &volumes.light, .means = true, .total = &volumes.total},
              volumes.next, false);
        std::swap(volumes.light, volumes.next);
        sum(order);
    }
    // What is looked up is the light at the nodes, not the means that went from order to order.
    carry(volumes,
          {.emits = medium.glows,
           .scattered = orders.count > 0 ? &volumes.total : nullptr,
           .tail = orders.tail && orders.count > 2 ? &volumes.light : nullptr},
          volumes.next, false);
    gl::Defines finish{{"kBands", fmt::format("{}", bands)}};
    if (world != nullptr) {
        finish.emplace_back("kWorld", "");
        world->bind(FIELD_WORLD_UNIT);
    }
    volumes.next.bind(FIELD_LIGHT_UNIT);
    volumes.total.bind(FIELD_ORDER_UNIT);
    image(0, field, GL_WRITE_ONLY, GL_RGBA16F);
    dispatch("light/field_finish.comp", finish, lattice.count, kVolumeGroup);
}

std::vector<glm::vec3> RadianceField::sums() const
{
    std::vector<glm::vec3> out;
    if (!sums_)
        return out;
    const std::vector<float> values = sums_.read(3);
    for (std::size_t i = 0; i < std::max(static_cast<std::size_t>(orders_), std::size_t{1}); ++i)
        out.emplace_back(values[3 * i], values[3 * i + 1], values[3 * i + 2]);
    return out;
}

}  // namespace fumarole::light
