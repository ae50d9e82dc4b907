#include "study/deep_still.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>

#include "gl/program.h"
#include "gl/texture.h"
#include "shared/volume_at_params.h"
#include <fumarole/errors.h>

namespace fumarole::study {

namespace {

constexpr std::uint32_t kBlock = 1, kFirstUnit = 2, kDepthUnit = kFirstUnit + kVolumeAtUnits;
constexpr int kMostDepths = 64;

/// Adds what the media do before each depth, no farther than the pixel's surface: radiance, and in
/// the alpha the mean transmittance.
std::string shader_text()
{
    return "#version 450 core\n" + volume_at_glsl({.block = kBlock, .first_unit = kFirstUnit}) +
           fmt::format(R"(
layout(local_size_x = 8, local_size_y = 8) in;
layout(rgba32f, binding = 0) uniform image2DArray u_sum_img;
layout(binding = {}) uniform sampler2D u_depth_tx;
uniform float u_view_z[{}];
uniform int u_count;
uniform vec4 u_clip;  // of the projection: p33, p32, p23, p22

void main()
{{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_sum_img).xy)))
        return;
    float n = texelFetch(u_depth_tx, pixel, 0).r;
    float surface = n == 0.0 ? {:e} : (u_clip.x * n - u_clip.y) / (u_clip.z * n - u_clip.w);
    for (int k = 0; k < u_count; ++k) {{
        fumarole_VolumeAt at =
            fumarole_volume_at(vec2(pixel) + 0.5, min(u_view_z[k], surface));
        vec4 before = imageLoad(u_sum_img, ivec3(pixel, k));
        vec4 here = vec4(at.scattering, dot(at.transmittance, vec3(1.0 / 3.0)));
        imageStore(u_sum_img, ivec3(pixel, k), before + here);
    }}
}}
)",
                       kDepthUnit, kMostDepths, Still::kSkyDepth);
}

float slice_view_z(float s, const shared::SliceParams& slices)
{
    float t = s;
    if (slices.spacing == SLICES_EXPONENTIAL)
        t = (std::exp2(slices.rate * s) - 1) / slices.exp2_rate_1;
    else if (slices.spacing == SLICES_POWER)
        t = std::pow(s, slices.rate);
    return slices.begin + slices.depth * t;
}

/// view_z [m], ascending, between which volume_at() is interpolated; empty where no medium is in
/// view.
std::vector<float> depths_of(const gl::Device& gl, const VolumeAtNames& names)
{
    shared::VolumeAtParams params;
    gl->GetNamedBufferSubData(names.block, 0, sizeof params, &params);
    std::vector<float> depths;
    if (params.kind == VOLUME_AT_SPLITS) {
        for (int k = 0; k < params.splits.count; ++k)
            depths.push_back(params.splits.view_z[k / 4][k % 4]);
    } else if (params.kind == VOLUME_AT_FROXELS) {
        const shared::SliceParams& slices = params.froxels.slices;
        const int count = std::min(static_cast<int>(slices.count), kMostDepths - 1);
        for (int k = 0; k <= count; ++k)
            depths.push_back(
                slice_view_z(static_cast<float>(k) / static_cast<float>(count), slices));
    }
    return depths;
}

/// What the media do before each of the depths, the mean of several frames.
struct Cuts {
    std::vector<float> view_z;
    int width = 0, height = 0;
    std::vector<float> sums;  ///< RGBA, rows from below, one depth after another
    float per_sum = 1;

    /// @param x, y from the top left
    [[nodiscard]] glm::vec4 at(int x, int y, std::size_t k) const
    {
        const std::size_t row =
            k * static_cast<std::size_t>(height) + static_cast<std::size_t>(height - 1 - y);
        const float* texel =
            &sums[4 * (row * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
        return per_sum * glm::vec4(texel[0], texel[1], texel[2], texel[3]);
    }
};

Cuts cut(SceneRenderer& scenes, const Scene& scene, const Settings& settings,
         const DeepOptions& options)
{
    Renderer& renderer = scenes.renderer();
    const gl::Device& gl = renderer.device();
    scenes.set_scene(scene, settings);
    const glm::ivec2 size(scene.resolution);
    const auto color =
        gl::Texture::make_2d(gl, "deep picture", size, GL_RGBA32F, gl::Filter::nearest);
    const auto depth = gl::Texture::make_2d(gl, "deep picture's depth", size, GL_DEPTH_COMPONENT32F,
                                            gl::Filter::nearest);
    View view = renderer.make_view(View::History::none);
    const std::string text = shader_text();
    const gl::Program program = gl::Program::compute(gl, "deep still", {text, {}});
    const auto place = [&](const char* name) { return gl->GetUniformLocation(program.id(), name); };
    gl::Texture sums;
    Cuts cuts;
    cuts.width = size.x;
    cuts.height = size.y;
    cuts.per_sum = 1.0f / static_cast<float>(options.frames);
    for (int i = 0; i < options.frames; ++i) {
        Frame frame =
            still_frame(scene.camera, settings, color.view(), depth.view(), i, options.seed);
        frame.transparents = {TransparentExtent{}};
        renderer.draw_surfaces(frame, settings, true);
        renderer.composite(view, frame, settings);
        const VolumeAtNames names = view.volume_at();
        if (i == 0) {
            cuts.view_z = depths_of(gl, names);
            if (cuts.view_z.empty())
                return cuts;
            sums = gl::Texture::make_2d_array(gl, "deep picture's cuts",
                                              {size, static_cast<int>(cuts.view_z.size())},
                                              GL_RGBA32F, gl::Filter::nearest);
            const glm::vec4 none(0);
            sums.clear(GL_RGBA, GL_FLOAT, &none);
        }
        const glm::dmat4& p = frame.clip_from_view;
        gl->ProgramUniform1fv(program.id(), place("u_view_z"),
                              static_cast<GLsizei>(cuts.view_z.size()), cuts.view_z.data());
        gl->ProgramUniform1i(program.id(), place("u_count"), static_cast<int>(cuts.view_z.size()));
        gl->ProgramUniform4f(program.id(), place("u_clip"), float(p[3][3]), float(p[3][2]),
                             float(p[2][3]), float(p[2][2]));
        gl->BindBufferBase(GL_UNIFORM_BUFFER, kBlock, names.block);
        gl->BindTextures(kFirstUnit, kVolumeAtUnits, names.textures.data());
        depth.bind(kDepthUnit);
        gl->BindImageTexture(0, sums.id(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA32F);
        gl->UseProgram(program.id());
        gl->DispatchCompute(GLuint(size.x + 7) / 8, GLuint(size.y + 7) / 8, 1);
        // The next frame's sum, and at last the read, follow.
        gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
        gl->UseProgram(0);
        gl->BindTextures(kFirstUnit, kVolumeAtUnits + 1, nullptr);
    }
    cuts.sums = sums.read(4);
    return cuts;
}

/// One pixel along depth.
class Pixel {
public:
    Pixel(const Cuts& cuts, int x, int y, float surface)
    {
        float through = 1;
        for (std::size_t k = 0; k < cuts.view_z.size(); ++k) {
            glm::vec4 here = cuts.at(x, y, k);
            through = std::min(through, std::clamp(here.w, 0.0f, 1.0f));
            if (k == 0)  // what a layer of fewer pixels has there already
                cuts_.push_back({std::min(cuts.view_z[k], surface), glm::vec3(0), 1});
            cuts_.push_back({std::min(cuts.view_z[k], surface), glm::vec3(here), through});
        }
    }

    /// What of the media is seen, and what they let through in all.
    [[nodiscard]] glm::vec3 radiance() const
    {
        return cuts_.empty() ? glm::vec3(0) : cuts_.back().radiance;
    }
    [[nodiscard]] float through() const { return cuts_.empty() ? 1.0f : cuts_.back().through; }

    /// Adds the fewest samples that keep what is seen before each cut.
    /// @param radiance how much of it may change
    void add_samples(std::vector<DeepSample>& out, float through, float radiance) const
    {
        std::size_t begin = 0;
        while (begin + 1 < cuts_.size()) {
            if (is_empty(begin, begin + 1)) {
                ++begin;
                continue;
            }
            std::size_t end = begin + 1;
            while (end + 1 < cuts_.size() && fits(begin, end + 1, through, radiance))
                ++end;
            out.push_back(sample(begin, end));
            begin = end;
        }
    }

private:
    struct Cut {
        float view_z;
        glm::vec3 radiance;  ///< of what lies before it
        float through;
    };

    static constexpr float kNothing = 1e-6f;

    [[nodiscard]] bool is_empty(std::size_t a, std::size_t b) const
    {
        const glm::vec3 more = glm::abs(cuts_[b].radiance - cuts_[a].radiance);
        return cuts_[a].through - cuts_[b].through <= kNothing &&
               std::max({more.r, more.g, more.b}) <= 0;
    }

    [[nodiscard]] DeepSample sample(std::size_t a, std::size_t b) const
    {
        const float before = std::max(cuts_[a].through, kNothing);
        return {cuts_[a].view_z, cuts_[b].view_z,
                std::clamp(1 - cuts_[b].through / before, 0.0f, 1.0f),
                (cuts_[b].radiance - cuts_[a].radiance) / before};
    }

    /// Whether one sample has all that the cuts in it have, as it is split there.
    [[nodiscard]] bool fits(std::size_t a, std::size_t b, float through, float radiance) const
    {
        const DeepSample all = sample(a, b);
        const float length = all.back - all.front;
        for (std::size_t k = a + 1; k < b; ++k) {
            const float share = length > 0 ? (cuts_[k].view_z - all.front) / length : 1.0f;
            const float alpha = 1 - std::pow(1 - all.alpha, share);
            const float part = all.alpha > kNothing ? alpha / all.alpha : share;
            const glm::vec3 error = glm::abs(
                cuts_[a].radiance + cuts_[a].through * part * all.color - cuts_[k].radiance);
            if (std::abs(cuts_[a].through * (1 - alpha) - cuts_[k].through) > through ||
                std::max({error.r, error.g, error.b}) > radiance)
                return false;
        }
        return true;
    }

    std::vector<Cut> cuts_;
};

/// What is behind the media, so that the flattened pixel is `seen`.
void add_surface(std::vector<DeepSample>& out, std::size_t first, const Pixel& media,
                 glm::vec4 seen, float view_z)
{
    constexpr float kLeast = 1e-4f;  // of light let through: less hides whatever is there
    const glm::vec3 rest = glm::vec3(seen) - media.radiance();
    const float through = media.through();
    if (through > kLeast) {
        const float alpha = std::clamp(1 - (1 - seen.w) / through, 0.0f, 1.0f);
        if (alpha > 0 || rest != glm::vec3(0))
            out.push_back({view_z, view_z, alpha, rest / through});
    } else if (out.size() > first) {
        float before = 1;
        for (std::size_t i = first; i + 1 < out.size(); ++i)
            before *= 1 - out[i].alpha;
        out.back().color += rest / std::max(before, kLeast);
    }
}

}  // namespace

DeepImage deep_still(SceneRenderer& scenes, const Scene& scene, const Settings& settings,
                     const Still& still, const DeepOptions& options)
{
    if (!scene.transparents.empty())
        throw Error("a deep picture has no place for transparents; leave them out of the scene, or "
                    "render them as a picture of their own");
    const int limit = scenes.renderer().device().capabilities().max_texture_2d;
    const glm::ivec2 size(scene.resolution);
    if (std::max(size.x, size.y) > limit)
        throw Error(fmt::format("a deep picture of {} x {} is larger than this GL draws ({} at "
                                "most); give a smaller size",
                                size.x, size.y, limit));
    const Cuts cuts = cut(scenes, scene, settings, options);
    const bool cut_out = !still.foreground.empty();
    const std::vector<float>& pixels = cut_out ? still.foreground : still.composite;
    const std::size_t channels = cut_out ? 4 : 3;
    const auto count = static_cast<std::size_t>(size.x) * static_cast<std::size_t>(size.y);
    double mean = 0;
    for (const float value : still.scattering)
        mean += double(value) / double(still.scattering.size());

    DeepImage image;
    image.width = size.x;
    image.height = size.y;
    constexpr double kMostSamples = 15.5;  // a pixel in the mean
    float tolerance = options.tolerance;
    do {
        image.first.assign(1, 0);
        image.samples.clear();
        for (std::size_t i = 0; i < count; ++i) {
            const float depth = still.depth[i];
            const Pixel media(cuts, int(i) % size.x, int(i) / size.x, depth);
            media.add_samples(image.samples, tolerance, tolerance * std::max(float(mean), 1e-6f));
            const float* rgb = &pixels[channels * i];
            add_surface(image.samples, image.first.back(), media,
                        {rgb[0], rgb[1], rgb[2], cut_out ? rgb[3] : 1.0f}, depth);
            image.first.push_back(image.samples.size());
        }
        tolerance *= 2;
    } while (double(image.samples.size()) > kMostSamples * double(count));
    return image;
}

}  // namespace fumarole::study
