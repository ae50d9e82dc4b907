#include "light/sky_share.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "light/surface_rays.h"
#include "shared/bindings.h"

namespace fumarole::light {

namespace {

/// Directions that stand for equal parts of the part of the sphere that each way is nearest to:
/// SKY_MAPS of each way.
std::vector<std::vector<glm::dvec3>> looks_of(const std::vector<glm::dvec3>& ways)
{
    constexpr int kFine = 16;  ///< times as many are shared out
    std::vector<std::vector<glm::dvec3>> cells(ways.size());
    for (const glm::dvec3& wi : even_directions(kFine * SKY_MAPS * static_cast<int>(ways.size()))) {
        std::size_t nearest = 0;
        for (std::size_t i = 1; i < ways.size(); ++i)
            if (glm::dot(ways[i], wi) > glm::dot(ways[nearest], wi))
                nearest = i;
        cells[nearest].push_back(wi);
    }
    // Lloyd 1982.
    for (std::vector<glm::dvec3>& cell : cells) {
        std::vector<glm::dvec3> centres;
        for (std::size_t i = 0; i < SKY_MAPS; ++i)
            centres.push_back(cell[(2 * i + 1) * cell.size() / (2 * SKY_MAPS)]);
        constexpr int kRounds = 8;
        for (int round = 0; round < kRounds; ++round) {
            std::vector<glm::dvec3> sums(SKY_MAPS, glm::dvec3(0));
            for (const glm::dvec3& wi : cell)
                sums[static_cast<std::size_t>(
                    std::max_element(centres.begin(), centres.end(),
                                     [&](const glm::dvec3& a, const glm::dvec3& b) {
                                         return glm::dot(a, wi) < glm::dot(b, wi);
                                     }) -
                    centres.begin())] += wi;
            for (std::size_t i = 0; i < SKY_MAPS; ++i)
                if (sums[i] != glm::dvec3(0))
                    centres[i] = glm::normalize(sums[i]);
        }
        cell = std::move(centres);
    }
    return cells;
}

/// Along a direction to light, over a box whose corners are eye-centred.
shared::SkyMap map_of(glm::dvec3 wi, const std::vector<glm::dvec3>& corners)
{
    const glm::dvec3 other = std::abs(wi.z) < 0.9 ? glm::dvec3(0, 0, 1) : glm::dvec3(1, 0, 0);
    const glm::dvec3 across = glm::normalize(glm::cross(other, wi));
    const auto over = [&](glm::dvec3 axis) {
        double low = 1e300, high = -1e300;
        for (const glm::dvec3& corner : corners) {
            low = std::min(low, glm::dot(axis, corner));
            high = std::max(high, glm::dot(axis, corner));
        }
        const double size = std::max(high - low, 1e-12);
        return glm::vec4(glm::dvec4(axis, -low) / size);
    };
    return {over(across), over(glm::cross(wi, across)), over(wi)};
}

int texels_of(const FieldLattice& lattice)
{
    // Texels from a node to the next, or more: a node nearer to a wall than half a texel may see
    // what is behind it.
    constexpr int kANode = 4, kFewest = 128, kMost = 512;
    const int nodes = std::max({lattice.count.x, lattice.count.y, lattice.count.z});
    int texels = kFewest;
    while (texels < kANode * nodes && texels < kMost)
        texels *= 2;
    return texels;
}

}  // namespace

const gl::Texture& SkyShare::shares(const FieldLattice& lattice,
                                    const std::vector<glm::dvec3>& ways, const Bounds& box,
                                    const surface::SurfaceSet& surfaces, glm::ivec3 size)
{
    const Key key{surfaces.shape(), ways.size(), lattice.node_from_eye, lattice.eye, size,
                  box.min,          box.max};
    if (shares_ && key == key_)
        return shares_;
    shares_ = gl::Texture::make_3d(device_, "the sky's shares", size, GL_R8UI, gl::Filter::nearest);
    key_ = key;
    fill(lattice, ways, box, surfaces);
    return shares_;
}

void SkyShare::fill(const FieldLattice& lattice, const std::vector<glm::dvec3>& ways,
                    const Bounds& box, const surface::SurfaceSet& surfaces)
{
    std::vector<glm::dvec3> corners;
    corners.reserve(8);
    for (int i = 0; i < 8; ++i)
        corners.push_back(glm::dvec3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
                                     i & 4 ? box.max.z : box.min.z) -
                          lattice.eye);
    Bounds nodes;
    for (const glm::dvec3& corner : corners)
        nodes.add(glm::dvec3(lattice.node_from_eye * glm::dvec4(corner, 1)));
    constexpr double kRim = 1e-3;
    shared::SkyMapParams params{};
    params.low = glm::vec3(nodes.min - kRim);
    params.high = glm::vec3(nodes.max + kRim);
    params.texels = texels_of(lattice);
    const gl::Texture maps =
        gl::Texture::make_2d(device_, "sky maps", glm::ivec2(SKY_MAPS_A_ROW * params.texels),
                             GL_DEPTH_COMPONENT16, gl::Filter::nearest);
    if (!framebuffer_)
        framebuffer_ = {device_, "sky maps"};
    framebuffer_.attach_depth(maps.view());
    for (const std::vector<glm::dvec3>& looks : looks_of(ways)) {
        for (std::size_t i = 0; i < SKY_MAPS; ++i)
            params.maps[i] = map_of(looks[i], corners);
        block_.write(params);
        device_->BindBufferBase(GL_UNIFORM_BUFFER, SKY_MAPS_BLOCK, block_.id());
        draw(lattice, surfaces, params.texels);
        maps.bind(FACE_LIGHT_UNIT);
        device_->BindImageTexture(0, shares_.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_R8UI);
        device_->UseProgram(programs_.get({"light/sky_share.comp"}, {}).id());
        const glm::uvec3 groups((lattice.count + VOLUME_GROUP - 1) / VOLUME_GROUP);
        device_->DispatchCompute(groups.x, groups.y, groups.z);
        ++params.way;
    }
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    framebuffer_.attach_depth({});
}

void SkyShare::draw(const FieldLattice& lattice, const surface::SurfaceSet& surfaces, int texels)
{
    framebuffer_.bind(glm::ivec2(SKY_MAPS_A_ROW * texels));
    const GLfloat none = 0;
    device_->DepthMask(GL_TRUE);
    device_->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &none);
    device_->Enable(GL_DEPTH_TEST);
    device_->Enable(GL_DEPTH_CLAMP);
    for (GLenum i = 0; i < 4; ++i)
        device_->Enable(GL_CLIP_DISTANCE0 + i);
    device_->DepthFunc(GL_GREATER);  // what is nearest to the light comes last
    device_->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, draw_block_.id());
    device_->UseProgram(programs_.get({"light/sky_map.vert", "light/sky_map.frag"}, {}).id());
    for (const auto& instance : surfaces.instances()) {
        shared::DrawParams params{};
        params.world_from_object =
            glm::mat4(glm::translate(glm::dmat4(1.0), -lattice.eye) * instance.world_from_object);
        draw_block_.write(params);
        surfaces.draw(instance, surface::SurfaceSet::Detail::coarse, SKY_MAPS);
    }
    for (GLenum i = 0; i < 4; ++i)
        device_->Disable(GL_CLIP_DISTANCE0 + i);
    device_->Disable(GL_DEPTH_CLAMP);
    device_->Disable(GL_DEPTH_TEST);
    device_->DepthMask(GL_FALSE);
    // llvmpipe: see RadianceField::wait_for_drawing().
    device_->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT | GL_FRAMEBUFFER_BARRIER_BIT);
}

}  // namespace fumarole::light
