#include "study/deep_still.h"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <oneapi/tbb/parallel_for.h>

#include "gl/program.h"
#include "gl/texture.h"
#include "picture_parts.h"
#include "shared/volume_at_params.h"
#include "study/reference_transparents.h"
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
uniform bool u_in_color;  // transmittance too, in as many layers more
uniform ivec2 u_origin;  // of what is kept in what was drawn
uniform vec4 u_clip;  // of the projection: p33, p32, p23, p22

void main()
{{
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(u_sum_img).xy)))
        return;
    ivec2 drawn = pixel + u_origin;
    float n = texelFetch(u_depth_tx, drawn, 0).r;
    float surface = n == 0.0 ? {:e} : (u_clip.x * n - u_clip.y) / (u_clip.z * n - u_clip.w);
    for (int k = 0; k < u_count; ++k) {{
        fumarole_VolumeAt at =
            fumarole_volume_at(vec2(drawn) + 0.5, min(u_view_z[k], surface));
        vec4 before = imageLoad(u_sum_img, ivec3(pixel, k));
        vec4 here = vec4(at.scattering, dot(at.transmittance, vec3(1.0 / 3.0)));
        imageStore(u_sum_img, ivec3(pixel, k), before + here);
        if (u_in_color) {{
            vec4 passed = imageLoad(u_sum_img, ivec3(pixel, u_count + k));
            imageStore(u_sum_img, ivec3(pixel, u_count + k), passed + vec4(at.transmittance, 0.0));
        }}
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

/// What is drawn of a picture, and kept of that.
PicturePart part_of(const Scene& scene, const DeepOptions& options, const Settings& settings,
                    int most_side)
{
    const glm::ivec2 size(scene.resolution);
    const PictureRegion region = options.region.value_or(PictureRegion{0, 0, size.x, size.y});
    const std::vector<PicturePart> parts = picture_parts(size, region, most_side, settings);
    if (parts.size() > 1)
        throw Error(fmt::format("a deep picture of {} x {} is larger than this GL draws ({} at "
                                "most); give a smaller size or region",
                                region.width, region.height, most_side));
    return parts.front();
}

/// A transparent in a pixel, the mean of several frames.
struct Layer {
    std::size_t index = 0;  ///< index of the transparent
    int crossing = 0;       ///< which of several with it
    int hits = 0;           ///< frames that meet it
    float view_z = 0;       ///< [m], the sum of those that meet it
    glm::vec3 added{0};     ///< radiance [W/m^2/sr], the sum of all
    glm::vec3 taken{0};     ///< the share of what is behind it that it hides, the sum of all
};

/// What of a picture's pixels transparents are, from the eye's rays through them.
class TransparentLayers {
public:
    TransparentLayers(const Scene& scene, const PicturePart& part)
        : scene_{scene}, part_{part}, transparents_{scene},
          pixels_(static_cast<std::size_t>(part.keep_size.x) *
                  static_cast<std::size_t>(part.keep_size.y))
    {
    }

    [[nodiscard]] bool empty() const { return transparents_.empty(); }

    /// Frame i of those that are averaged.
    /// @param window_depth of what was drawn, rows from below, reversed
    void add(int i, const std::vector<float>& window_depth)
    {
        const glm::dmat4 world_from_clip =
            glm::inverse(clip_from_view(scene_.camera, scene_.resolution, subpixel_offset(i)) *
                         view_from_world(scene_.camera));
        oneapi::tbb::parallel_for(0, part_.keep_size.y, [&](int row) {
            for (int x = 0; x < part_.keep_size.x; ++x) {
                const glm::ivec2 drawn = part_.keep_origin + glm::ivec2(x, row);
                const float n = window_depth[static_cast<std::size_t>(drawn.y) *
                                                 static_cast<std::size_t>(part_.size.x) +
                                             static_cast<std::size_t>(drawn.x)];
                add(pixels_[index_of(x, part_.keep_size.y - 1 - row)], part_.origin + drawn,
                    world_from_clip, double(n));
            }
        });
    }

    /// @param x, y from the top left of what is kept
    [[nodiscard]] const std::vector<Layer>& at(int x, int y) const
    {
        return pixels_[index_of(x, y)];
    }

private:
    [[nodiscard]] std::size_t index_of(int x, int y) const
    {
        return static_cast<std::size_t>(y) * static_cast<std::size_t>(part_.keep_size.x) +
               static_cast<std::size_t>(x);
    }

    void add(std::vector<Layer>& layers, glm::ivec2 at, const glm::dmat4& world_from_clip, double n)
    {
        const glm::dvec2 ndc = (glm::dvec2(at) + 0.5) / glm::dvec2(scene_.resolution) * 2.0 - 1.0;
        const auto place = [&](double depth) {
            const glm::dvec4 p = world_from_clip * glm::dvec4(ndc, depth, 1);
            return glm::dvec3(p) / p.w;
        };
        const glm::dvec3 near = place(1), far = place(0);
        const double length = glm::distance(near, far);
        const double surface = n > 0 ? glm::distance(near, place(n)) : kInfinity;
        const std::vector<TransparentHit> hits =
            transparents_.along({near, (far - near) / length}, 0, length, surface);
        double alpha = 1;  // of what is behind, which factors may ask for
        for (std::size_t k = hits.size(); k-- > 0;) {
            const TransparentHit& hit = hits[k];
            // Linear in what is behind, so black and white tell all of it: factors of its colour
            // too, where they are the source's.
            const glm::dvec4 over = hit.over({0, 0, 0, alpha});
            const glm::dvec3 kept = hit.over({1, 1, 1, alpha}) - over;
            Layer& layer = layer_of(layers, hit.index,
                                    static_cast<int>(std::count_if(
                                        hits.begin(), hits.begin() + std::ptrdiff_t(k),
                                        [&](const auto& o) { return o.index == hit.index; })));
            ++layer.hits;
            const double along = hit.t / length;
            layer.view_z +=
                float(scene_.camera.near + along * (scene_.camera.far - scene_.camera.near));
            layer.added += glm::vec3(over);
            layer.taken += glm::vec3(1.0 - kept);
            alpha = over.a;
        }
    }

    static Layer& layer_of(std::vector<Layer>& layers, std::size_t index, int crossing)
    {
        for (Layer& layer : layers)
            if (layer.index == index && layer.crossing == crossing)
                return layer;
        layers.push_back({.index = index, .crossing = crossing});
        return layers.back();
    }

    const Scene& scene_;
    const PicturePart& part_;
    ReferenceTransparents transparents_;
    std::vector<std::vector<Layer>> pixels_;
};

/// What the media do before each of the depths, the mean of several frames.
struct Cuts {
    std::vector<float> view_z;
    int width = 0, height = 0;
    bool in_color = false;    ///< transmittance too
    std::vector<float> sums;  ///< RGBA, rows from below, one depth after another
    float per_sum = 1;

    /// Radiance before a depth, and in the alpha the mean of what is let through.
    /// @param x, y from the top left
    [[nodiscard]] glm::vec4 at(int x, int y, std::size_t k) const { return texel(x, y, k); }

    /// What is let through, with its colours if they are known.
    [[nodiscard]] glm::vec3 passed(int x, int y, std::size_t k) const
    {
        return in_color ? glm::vec3(texel(x, y, view_z.size() + k)) : glm::vec3(texel(x, y, k).w);
    }

private:
    [[nodiscard]] glm::vec4 texel(int x, int y, std::size_t layer) const
    {
        const std::size_t row =
            layer * static_cast<std::size_t>(height) + static_cast<std::size_t>(height - 1 - y);
        const float* first =
            &sums[4 * (row * static_cast<std::size_t>(width) + static_cast<std::size_t>(x))];
        return per_sum * glm::vec4(first[0], first[1], first[2], first[3]);
    }
};

Cuts cut(SceneRenderer& scenes, const Scene& scene, const Settings& settings,
         const PicturePart& part, const DeepOptions& options, TransparentLayers& layers)
{
    Renderer& renderer = scenes.renderer();
    const gl::Device& gl = renderer.device();
    const auto color =
        gl::Texture::make_2d(gl, "deep picture", part.size, GL_RGBA32F, gl::Filter::nearest);
    const auto depth = gl::Texture::make_2d(gl, "deep picture's depth", part.size,
                                            GL_DEPTH_COMPONENT32F, gl::Filter::nearest);
    View view = renderer.make_view(View::History::none);
    const std::string text = shader_text();
    const gl::Program program = gl::Program::compute(gl, "deep still", {text, {}});
    const auto place = [&](const char* name) { return gl->GetUniformLocation(program.id(), name); };
    gl::Texture sums;
    Cuts cuts;
    cuts.width = part.keep_size.x;
    cuts.height = part.keep_size.y;
    cuts.per_sum = 1.0f / static_cast<float>(options.frames);
    for (int i = 0; i < options.frames; ++i) {
        Frame frame =
            still_frame(scene.camera, settings, color.view(), depth.view(), i, options.seed);
        frame.clip_from_view =
            clip_of_part(clip_from_view(scene.camera, scene.resolution, subpixel_offset(i)),
                         glm::ivec2(scene.resolution), part);
        frame.transparents = {TransparentExtent{}};
        renderer.draw_surfaces(frame, settings, true);
        if (!layers.empty())
            layers.add(i, gl::read_texture(gl, depth.view(), 1, true));
        renderer.composite(view, frame, settings);
        const VolumeAtNames names = view.volume_at();
        if (i == 0) {
            cuts.view_z = depths_of(gl, names);
            cuts.in_color = !layers.empty();
            if (!cuts.view_z.empty()) {
                const int count = int(cuts.view_z.size()) * (cuts.in_color ? 2 : 1);
                sums =
                    gl::Texture::make_2d_array(gl, "deep picture's cuts", {part.keep_size, count},
                                               GL_RGBA32F, gl::Filter::nearest);
                const glm::vec4 none(0);
                sums.clear(GL_RGBA, GL_FLOAT, &none);
            }
        }
        if (cuts.view_z.empty())
            continue;
        const glm::dmat4& p = frame.clip_from_view;
        gl->ProgramUniform1fv(program.id(), place("u_view_z"),
                              static_cast<GLsizei>(cuts.view_z.size()), cuts.view_z.data());
        gl->ProgramUniform1i(program.id(), place("u_count"), static_cast<int>(cuts.view_z.size()));
        gl->ProgramUniform1i(program.id(), place("u_in_color"), cuts.in_color ? 1 : 0);
        gl->ProgramUniform2i(program.id(), place("u_origin"), part.keep_origin.x,
                             part.keep_origin.y);
        gl->ProgramUniform4f(program.id(), place("u_clip"), float(p[3][3]), float(p[3][2]),
                             float(p[2][3]), float(p[2][2]));
        gl->BindBufferBase(GL_UNIFORM_BUFFER, kBlock, names.block);
        gl->BindTextures(kFirstUnit, kVolumeAtUnits, names.textures.data());
        depth.bind(kDepthUnit);
        gl->BindImageTexture(0, sums.id(), 0, GL_TRUE, 0, GL_READ_WRITE, GL_RGBA32F);
        gl->UseProgram(program.id());
        gl->DispatchCompute(GLuint(part.keep_size.x + 7) / 8, GLuint(part.keep_size.y + 7) / 8, 1);
        // The next frame's sum, and at last the read, follow.
        gl->MemoryBarrier(GL_SHADER_IMAGE_ACCESS_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT);
        gl->UseProgram(0);
        gl->BindTextures(kFirstUnit, kVolumeAtUnits + 1, nullptr);
    }
    if (!cuts.view_z.empty())
        cuts.sums = sums.read(4);
    return cuts;
}

/// A transparent in a pixel.
struct Pane {
    float view_z = 0;    ///< [m]
    glm::vec3 added{0};  ///< radiance [W/m^2/sr]
    glm::vec3 kept{1};   ///< share of what is behind it
};

/// The layers of a pixel from near to far; of two at one depth the later transparent is in front.
std::vector<Pane> panes_of(std::vector<Layer> layers, int frames, float surface)
{
    for (Layer& layer : layers)
        layer.view_z = std::min(layer.view_z / float(layer.hits), surface);
    std::sort(layers.begin(), layers.end(), [](const Layer& a, const Layer& b) {
        return a.view_z < b.view_z || (a.view_z == b.view_z && a.index > b.index);
    });
    std::vector<Pane> panes;
    panes.reserve(layers.size());
    for (const Layer& layer : layers)
        panes.push_back(
            {layer.view_z, layer.added / float(frames), 1.0f - layer.taken / float(frames)});
    return panes;
}

/// One pixel along depth.
class Pixel {
public:
    /// @param panes from near to far, none behind the surface
    Pixel(const Cuts& cuts, int x, int y, float surface, const std::vector<Pane>& panes)
    {
        Met met;
        auto pane = panes.begin();
        for (std::size_t k = 0; k < cuts.view_z.size(); ++k) {
            const Met next{std::min(cuts.view_z[k], surface), glm::vec3(cuts.at(x, y, k)),
                           glm::min(glm::clamp(cuts.passed(x, y, k), 0.0f, 1.0f), met.passed)};
            if (k == 0)
                met.view_z = next.view_z;
            for (; pane != panes.end() && pane->view_z < next.view_z; ++pane) {
                if (k > 0)
                    go_to(between(met, next, pane->view_z), met);
                add(*pane, met);
            }
            if (k == 0)  // what a layer of fewer pixels has there already
                add_cut(next.view_z, met);
            go_to(next, met);
        }
        for (; pane != panes.end(); ++pane)
            add(*pane, met);
    }

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
            while (!cuts_[end].ends_pane && end + 1 < cuts_.size() && !cuts_[end + 1].ends_pane &&
                   fits(begin, end + 1, through, radiance))
                ++end;
            out.push_back(sample(begin, end));
            begin = end;
        }
    }

private:
    struct Cut {
        float view_z;
        glm::vec3 radiance;      ///< radiance of what lies before it
        float through;           ///< the mean of what is let through
        bool ends_pane = false;  ///< what lies between it and the one before is a transparent
    };

    /// What a ray has met of the media.
    struct Met {
        float view_z = 0;
        glm::vec3 radiance{0}, passed{1};
    };

    /// Between two depths the medium is uniform.
    static Met between(const Met& a, const Met& b, float view_z)
    {
        const float share = (view_z - a.view_z) / std::max(b.view_z - a.view_z, 1e-30f);
        Met met{view_z, a.radiance, a.passed};
        for (int c = 0; c < 3; ++c) {
            const float all = a.passed[c] > kNothing ? b.passed[c] / a.passed[c] : 1.0f;
            const float part = std::pow(all, share);
            met.passed[c] *= part;
            met.radiance[c] += (b.radiance[c] - a.radiance[c]) *
                               (1 - all > kNothing ? (1 - part) / (1 - all) : share);
        }
        return met;
    }

    void go_to(const Met& next, Met& met)
    {
        seen_ += kept_ * (next.radiance - met.radiance);
        met = next;
        add_cut(met.view_z, met);
    }

    void add(const Pane& pane, const Met& met)
    {
        add_cut(pane.view_z, met);
        seen_ += kept_ * met.passed * pane.added;
        kept_ *= pane.kept;
        add_cut(pane.view_z, met);
        cuts_.back().ends_pane = true;
    }

    void add_cut(float view_z, const Met& met)
    {
        const glm::vec3 through = kept_ * met.passed;
        const float mean = std::clamp((through.r + through.g + through.b) / 3, 0.0f, 1.0f);
        cuts_.push_back(
            {view_z, seen_, cuts_.empty() ? mean : std::min(mean, cuts_.back().through)});
    }

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
    glm::vec3 seen_{0}, kept_{1};  ///< radiance so far; what transparents keep of what is behind
};

/// Light that comes through everything, less than which hides whatever is behind.
constexpr float kLeastThrough = 1e-4f;

/// Ends a pixel with what is behind its media and transparents, so that flattened it is `seen`.
void add_surface(std::vector<DeepSample>& out, std::size_t first, glm::vec4 seen, float view_z)
{
    glm::vec3 radiance(0);
    float through = 1, before = 1;
    for (std::size_t i = first; i < out.size() && through > kLeastThrough; ++i) {
        before = through;
        radiance += through * out[i].color;
        through *= 1 - out[i].alpha;
        if (through <= kLeastThrough)
            out.resize(i + 1);
    }
    // GL may leave out what a ray just meets at a transparent's edge: that hides as much less.
    for (std::size_t i = first; i < out.size() && through > kLeastThrough && through < 1 - seen.w;
         ++i) {
        if (out[i].front < out[i].back || out[i].alpha == 0)
            continue;
        const float kept = std::min((1 - out[i].alpha) * (1 - seen.w) / through, 1.0f);
        const float more = kept / (1 - out[i].alpha);
        out[i].alpha = 1 - kept;
        through *= more;
        for (std::size_t behind = i + 1; behind < out.size(); ++behind)
            out[behind].color /= more;
    }
    const glm::vec3 rest = glm::vec3(seen) - radiance;
    if (through > kLeastThrough) {
        const float alpha = std::clamp(1 - (1 - seen.w) / through, 0.0f, 1.0f);
        if (alpha > 0 || rest != glm::vec3(0))
            out.push_back({view_z, view_z, alpha, rest / through});
    } else if (out.size() > first) {
        out.back().color += rest / before;
    }
}

/// @throws Error if a transparent makes of what is behind it what no sample can: what a sample adds
/// and what it lets through are known before what is behind it is, so that must be linear.
void check_transparents(const Scene& scene)
{
    for (std::size_t i = 0; i < scene.transparents.size(); ++i) {
        const Blend& blend = look_of(scene.transparents[i]).blend;
        if (blend.kind == Blend::Kind::factors &&
            (blend.destination == BlendFactor::dst_color ||
             blend.destination == BlendFactor::one_minus_dst_color))
            throw Error(fmt::format(
                "transparents[{}]: its blend takes the square of the color behind it (destination "
                "factor dst_color or one_minus_dst_color), and a deep sample is made before that "
                "is known; give it another destination factor, or write a flat .exr",
                i));
    }
}

}  // namespace

DeepImage deep_still(SceneRenderer& scenes, const Scene& scene, const Settings& asked,
                     const Still& still, const DeepOptions& options)
{
    check_transparents(scene);
    scenes.set_scene(scene, asked);
    StillOptions drawn;
    drawn.aa = options.frames;
    const Settings settings = scenes.settled(scene, asked, drawn);
    const PicturePart part =
        part_of(scene, options, settings, scenes.renderer().device().capabilities().max_texture_2d);
    TransparentLayers layers(scene, part);
    const Cuts cuts = cut(scenes, scene, settings, part, options, layers);
    const glm::ivec2 size = part.keep_size;
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
    if (options.region) {
        image.origin = {options.region->x, options.region->y};
        image.whole = glm::ivec2(scene.resolution);
    }
    constexpr double kMostSamples = 15.5;  // a pixel in the mean
    float tolerance = options.tolerance;
    do {
        image.first.assign(1, 0);
        image.samples.clear();
        for (std::size_t i = 0; i < count; ++i) {
            const float depth = still.depth[i];
            const int x = int(i) % size.x, y = int(i) / size.x;
            const Pixel pixel(cuts, x, y, depth, panes_of(layers.at(x, y), options.frames, depth));
            pixel.add_samples(image.samples, tolerance, tolerance * std::max(float(mean), 1e-6f));
            const float* rgb = &pixels[channels * i];
            add_surface(image.samples, image.first.back(),
                        {rgb[0], rgb[1], rgb[2], cut_out ? rgb[3] : 1.0f}, depth);
            image.first.push_back(image.samples.size());
        }
        tolerance *= 2;
    } while (double(image.samples.size()) > kMostSamples * double(count));
    return image;
}

}  // namespace fumarole::study
