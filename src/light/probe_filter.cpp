#include "light/probe_filter.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>
#include <string>

namespace fumarole::light {

namespace {

int octaves_of(int size)
{
    int count = 0;
    for (; size > 1; size /= 2)
        ++count;
    return count;
}

/// Means of a map and of it at half the size, and so on, as glsl/probe/filter.comp finds them.
glm::ivec2 pyramid_size(int n)
{
    return {n + n / 2 + 4, n + 2 * octaves_of(n)};
}

shared::ProbeMap pyramid_map(int n, int level)
{
    const int size = n >> level;
    if (level == 0)
        return {{1, 1}, size, 0};
    return {{n + 3, 1 + n - 2 * size + 2 * (level - 1)}, size, 0};
}

}  // namespace

ProbeLayout::ProbeLayout(int size)
{
    assert(size >= 64 && size <= 1024 && (size & (size - 1)) == 0);
    // A lobe is some 3 alpha wide: 6 texels of an even map, as far as the first has them. The
    // widest ones end at the horizon in an edge.
    const int most = std::min(256, size / 2), least = std::min(64, size / 2);
    const int last = std::clamp(octaves_of(size) - 2, 1, PROBE_MAPS - 1);
    maps_.push_back({{1, 1}, size, 0});
    size_ = glm::ivec2(size + 2);
    glm::ivec2 next(size + 3, 1);
    bool below = false;
    for (int i = 1; i <= last; ++i) {
        const double alpha = std::exp2(i - last);
        const int texels = std::clamp(static_cast<int>(8 / alpha), least, most);
        if (!below && next.y + texels + 1 > size + 4) {  // above each other beside the first map
            below = true;
            next = {1, size_.y + 1};
        }
        maps_.push_back({next, texels, alpha});
        size_ = glm::max(size_, next + texels + 1);
        (below ? next.x : next.y) += texels + 2;
    }
    ++size_.y;  // the harmonics
}

shared::ProbeLayoutParams ProbeLayout::params() const
{
    shared::ProbeLayoutParams params{};
    const glm::dvec2 size(size_);
    for (std::size_t i = 0; i < maps_.size(); ++i)
        params.maps[i] = glm::vec4(glm::dvec2(maps_[i].first) / size, double(maps_[i].size) / size);
    params.last = static_cast<float>(maps_.size() - 1);
    params.harmonics = harmonics_row();
    return params;
}

gl::Texture ProbeFilter::make_maps(std::string_view label, const ProbeLayout& layout,
                                   int layers) const
{
    return gl::Texture::make_2d_array(device_, label, glm::ivec3(layout.size(), layers), GL_RGBA32F,
                                      gl::Filter::linear);
}

void ProbeFilter::filter_environment(const gl::Texture& map, const gl::Texture& to,
                                     const ProbeLayout& layout, int layer) const
{
    // A texel of the octahedron covers up to 5.2 times what its smallest does. Two samples a texel
    // of the map along each edge, or a sun of a few texels is taken for a tenth more or less.
    const double texel = 3.2 / layout.maps().front().size;
    const int samples =
        std::max(2, static_cast<int>(std::ceil(2 * texel * map.size().x / (2 * std::numbers::pi))));
    filter(map, {{"kSamples", std::to_string(samples)}}, to, layout, layer);
}

void ProbeFilter::filter_faces(const gl::Texture& faces, const gl::Texture& to,
                               const ProbeLayout& layout, int layer) const
{
    filter(faces, {{"FACES", ""}}, to, layout, layer);
}

void ProbeFilter::filter(const gl::Texture& source, const gl::Defines& resolve,
                         const gl::Texture& to, const ProbeLayout& layout, int layer) const
{
    constexpr int kGroup = 8;
    // Texels as wide as two suns: harmonics of 64 along an edge put one 3 degrees off.
    constexpr int kForHarmonics = 256;
    const gl::Device& gl = device_;
    const int n = layout.maps().front().size;
    if (!pyramid_ || glm::ivec2(pyramid_.size()) != pyramid_size(n))
        pyramid_ = gl::Texture::make_2d_array(gl, "probe's means", glm::ivec3(pyramid_size(n), 1),
                                              GL_RGBA32F, gl::Filter::linear);
    const gl::Texture& pyramid = pyramid_;
    shared::ProbeFilterParams params{};
    const auto run = [&](const char* file, const gl::Defines& defines, const gl::Texture& from,
                         const gl::Texture& into, glm::ivec2 threads) {
        block_.write(params);
        gl->UseProgram(programs_.get({file}, defines).id());
        gl->BindBufferBase(GL_UNIFORM_BUFFER, PROBE_FILTER_BLOCK, block_.id());
        from.bind(PROBE_SOURCE_UNIT);
        gl->BindImageTexture(0, into.id(), 0, GL_TRUE, 0, GL_WRITE_ONLY, GL_RGBA32F);
        const auto groups = glm::uvec2((threads + kGroup - 1) / kGroup);
        gl->DispatchCompute(groups.x, groups.y, 1);
        gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
    };
    params.to = pyramid_map(n, 0);
    run("probe/resolve.comp", resolve, source, pyramid, glm::ivec2(n + 2));
    for (int level = 1; level <= octaves_of(n); ++level) {
        params.from = pyramid_map(n, level - 1);
        params.to = pyramid_map(n, level);
        run("probe/shrink.comp", {}, pyramid, pyramid, glm::ivec2(params.to.size + 2));
    }
    params.from = pyramid_map(n, 0);
    for (const ProbeLayout::Map& map : layout.maps()) {
        if (map.alpha == 0)
            continue;
        params.to = {map.first, map.size, layer};
        params.alpha = static_cast<float>(map.alpha);
        run("probe/filter.comp", {}, pyramid, to, glm::ivec2(map.size + 2));
    }
    params.from = pyramid_map(n, std::max(0, octaves_of(n / kForHarmonics)));
    params.to = {{0, layout.harmonics_row()}, 1, layer};
    run("probe/harmonics.comp", {}, pyramid, to, glm::ivec2(1));
    // The mirror's is the largest of the means, with its border.
    gl->MemoryBarrier(GL_TEXTURE_UPDATE_BARRIER_BIT | GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    gl->CopyImageSubData(pyramid.id(), GL_TEXTURE_2D_ARRAY, 0, 0, 0, 0, to.id(),
                         GL_TEXTURE_2D_ARRAY, 0, 0, 0, layer, n + 2, n + 2, 1);
}

}  // namespace fumarole::light
