#include "resolve/inspect.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <fmt/format.h>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>
#include <vector>

#include "gl/buffer.h"
#include "resolve/composite.h"
#include "scale_end.h"
#include "shared/bindings.h"
#include "shared/inspect_params.h"
#include <fumarole/errors.h>

namespace fumarole::resolve {

namespace {

using Kind = Inspection::Kind;

void check(const Inspection& wanted, const FrameSettings& settings)
{
    if (wanted.kind == Kind::froxel_slice && settings.mode != Settings::Mode::froxel)
        throw Error("froxel-slice: a ray march has no froxels; use FrameSettings::mode froxel");
    if (wanted.axis < 0 || wanted.axis > 2)
        throw Error(fmt::format("a slice's axis is 0, 1 or 2, and not {}", wanted.axis));
    if (!(wanted.position >= 0 && wanted.position <= 1))
        throw Error(fmt::format("a slice's position is 0..1, and not {}", wanted.position));
    if (!(wanted.scale >= 0 && std::isfinite(wanted.scale)))
        throw Error(fmt::format("a colour scale ends above 0, and not at {}", wanted.scale));
}

/// A box to be drawn as glsl/pass/inspect_box.vert has it.
struct BoxInstance {
    glm::vec4 min{0};  ///< w: value, or less than 0 for an outline
    glm::vec4 max{0};
};
constexpr float kOutline = -1;
constexpr GLsizei kEdgeVertices = 24;

BoxInstance outline(glm::dvec3 min, glm::dvec3 max)
{
    return {glm::vec4(glm::vec3(min), kOutline), glm::vec4(glm::vec3(max), 0)};
}

/// Where a colour scale ends.
enum class Ends {
    round,  ///< ends at 0, and where the legend says or at a round number above what is seen
    seen,   ///< ends at the least that is seen, and where the legend says or at the largest
};
constexpr double kLeastEnd = 1e-6;

double largest_of(const medium::Occupied& kept)
{
    double largest = 0;
    for (const medium::OccupiedBox& box : kept.boxes)
        largest = std::max(largest, static_cast<double>(box.most));
    return largest;
}

/// One inspection of one frame.
class Inspector {
public:
    Inspector(const Toolbox& tools, gl::Framebuffer& host, const PreparedFrame& frame)
        : tools_{tools}, host_{host}, frame_{frame}, block_{tools.device, "inspection"}
    {
    }

    shared::InspectParams params{};  ///< params of the next draw

    /// A layer as it is; `layers` null: none that differs from nothing at all.
    void show_layer(Layers* layers, Layer layer) const;
    /// What a shader draws, over all of the picture.
    void show(const char* fragment_file) const;
    /// The picture that is there, darkened.
    void dim() const;
    /// The values that `draw` draws into the framebuffer that is bound, in colours, whose ends are
    /// left in `legend`.
    void show_values(const std::function<void()>& draw, Ends ends, InspectionLegend& legend);
    void set_scale(const InspectionLegend& legend)
    {
        params.scale_begin = static_cast<float>(legend.low);
        params.inverse_scale_width = static_cast<float>(1 / (legend.high - legend.low));
    }
    /// Wire boxes before the scene's surfaces. Sorts them, so that the largest values are seen.
    void draw_boxes(std::vector<BoxInstance> boxes, const glm::dmat4& world_from_boxes);

private:
    void bind_host() const
    {
        host_.bind(size());
        tools_.device->ColorMaski(0, GL_TRUE, GL_TRUE, GL_TRUE, GL_FALSE);
    }
    void bind_block() const
    {
        block_.write(params);
        tools_.device->BindBufferBase(GL_UNIFORM_BUFFER, INSPECT_BLOCK, block_.id());
    }
    [[nodiscard]] glm::ivec2 size() const { return frame_.picture_size; }
    [[nodiscard]] glm::dvec2 extent_of(const gl::Texture& values) const;

    const Toolbox& tools_;
    gl::Framebuffer& host_;
    const PreparedFrame& frame_;
    gl::UniformBuffer<shared::InspectParams> block_;
};

void Inspector::show_layer(Layers* layers, Layer layer) const
{
    const gl::Device& gl = tools_.device;
    if (layers != nullptr)
        layers->draw(frame_);
    bind_host();
    const bool scattering = layer == Layer::scattering;
    const glm::vec4 nothing(scattering ? 0.0f : 1.0f);
    gl->ClearNamedFramebufferfv(host_.id(), GL_COLOR, 0, &nothing.x);
    if (layers == nullptr)
        return;
    const auto time = tools_.timers.scope("inspection");
    draw_layer(tools_, *layers, make_canvas(tools_, host_, frame_.picture(), frame_.settings),
               frame_, layer);
}

void Inspector::show(const char* fragment_file) const
{
    const auto time = tools_.timers.scope("inspection");
    bind_host();
    bind_block();
    tools_.draw_fullscreen(fragment_file, {});
}

void Inspector::dim() const
{
    const gl::Device& gl = tools_.device;
    bind_host();
    gl->Enablei(GL_BLEND, 0);
    gl->BlendEquationi(0, GL_FUNC_ADD);
    gl->BlendFunci(0, GL_ZERO, GL_SRC_COLOR);
    tools_.draw_fullscreen("pass/inspect_dim.frag", {});
    gl->Disablei(GL_BLEND, 0);
}

/// The least and the largest value; the least is above the largest where there are none.
glm::dvec2 Inspector::extent_of(const gl::Texture& values) const
{
    constexpr glm::ivec2 kTiles(EXTENT_TILES);
    const gl::Texture tiles = gl::Texture::make_2d(tools_.device, "ends of the values", kTiles,
                                                   GL_RGBA32F, gl::Filter::nearest);
    gl::Framebuffer framebuffer(tools_.device, "ends of the values");
    framebuffer.attach_color({tiles.view()});
    framebuffer.bind(kTiles);
    values.bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_extent.frag", {});
    const std::vector<float> ends = tiles.read(4);
    glm::dvec2 extent(ends[0], ends[1]);
    for (std::size_t i = 0; i < ends.size(); i += 4)
        extent = {std::min<double>(extent.x, ends[i]), std::max<double>(extent.y, ends[i + 1])};
    return extent;
}

void Inspector::show_values(const std::function<void()>& draw, Ends ends, InspectionLegend& legend)
{
    const gl::Texture values = gl::Texture::make_2d(tools_.device, "inspected values", size(),
                                                    GL_R32F, gl::Filter::nearest);
    gl::Framebuffer framebuffer(tools_.device, "inspected values");
    framebuffer.attach_color({values.view()});
    bind_block();
    framebuffer.bind(size());
    draw();
    const auto time = tools_.timers.scope("inspection");
    if (ends == Ends::seen || legend.high <= 0) {
        const glm::dvec2 seen = extent_of(values);
        const bool nothing = seen.x > seen.y;
        if (ends == Ends::seen && !nothing)
            legend.low = seen.x;
        if (legend.high <= 0)
            legend.high = nothing              ? 1
                          : ends == Ends::seen ? seen.y
                                               : scale_end(std::max(seen.y, kLeastEnd));
        if (!(legend.low < legend.high))  // one value alone, or all of them beyond the scale
            legend.low = std::min(0.0, legend.high - 1);
    }
    set_scale(legend);
    dim();
    bind_block();
    values.bind(INSPECTED_UNIT);
    tools_.draw_fullscreen("pass/inspect_color.frag", {});
}

void Inspector::draw_boxes(std::vector<BoxInstance> boxes, const glm::dmat4& world_from_boxes)
{
    if (boxes.empty())
        return;
    std::stable_sort(boxes.begin(), boxes.end(),
                     [](const auto& a, const auto& b) { return a.min.w < b.min.w; });
    const gl::Device& gl = tools_.device;
    const gl::Buffer instances(gl, "inspected boxes", boxes.size() * sizeof(BoxInstance),
                               boxes.data());
    const gl::VertexArray vertex_array(gl, "inspected boxes");
    gl->VertexArrayVertexBuffer(vertex_array.id(), 0, instances.id(), 0, sizeof(BoxInstance));
    gl->VertexArrayBindingDivisor(vertex_array.id(), 0, 1);
    constexpr std::array kOffsets{offsetof(BoxInstance, min), offsetof(BoxInstance, max)};
    for (GLuint attribute = 0; attribute < kOffsets.size(); ++attribute) {
        gl->EnableVertexArrayAttrib(vertex_array.id(), attribute);
        gl->VertexArrayAttribFormat(vertex_array.id(), attribute, 4, GL_FLOAT, GL_FALSE,
                                    static_cast<GLuint>(kOffsets.at(attribute)));
        gl->VertexArrayAttribBinding(vertex_array.id(), attribute, 0);
    }
    params.clip_from_boxes =
        glm::mat4(frame_.host.clip_from_view * frame_.host.view_from_world * world_from_boxes);
    bind_block();
    host_.attach_depth(frame_.host.depth);
    bind_host();
    const DepthConvention& depth = frame_.host.depth_convention;
    gl->ClipControl(GL_LOWER_LEFT, depth.zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(depth.reversed ? GL_GEQUAL : GL_LEQUAL);
    const std::vector<std::string> files{"pass/inspect_box.vert", "pass/inspect_box.frag"};
    gl->UseProgram(tools_.programs.get(files, {}).id());
    gl->BindVertexArray(vertex_array.id());
    gl->DrawArraysInstanced(GL_LINES, 0, kEdgeVertices, static_cast<GLsizei>(boxes.size()));
    gl->Disable(GL_DEPTH_TEST);
    host_.attach_depth({});
}

InspectionLegend layer_legend(Kind kind)
{
    if (kind == Kind::scattering)
        return {0, 1, "W/m^2/sr", "scattering", false};
    return {0, 1, "", "transmittance", false};
}

void show_depth(const Toolbox& tools, Inspector& inspector, InspectionLegend& legend)
{
    legend.unit = "m";
    legend.caption = "view depth";
    inspector.show_values([&] { tools.draw_fullscreen("pass/inspect_depth.frag", {}); }, Ends::seen,
                          legend);
}

void show_samples(pass::VolumePass& volume, Inspector& inspector, const PreparedFrame& frame,
                  InspectionLegend& legend)
{
    const FrameSettings& s = frame.settings;
    const bool froxel = s.mode == Settings::Mode::froxel;
    const int pixels = froxel ? s.tile : s.resolution;
    legend.caption = fmt::format("evaluations of the media a {}, which {} x {} pixels have",
                                 froxel ? "column of froxels" : "ray", pixels, pixels);
    const gl::Texture counts = volume.sample_counts(frame);
    inspector.show_values([&] { volume.show_samples(frame, counts); }, Ends::round, legend);
}

void show_froxels(Layers& layers, Inspector& inspector, const PreparedFrame& frame, double position,
                  InspectionLegend& legend)
{
    const int slices = frame.settings.slices;
    const int slice = std::min(static_cast<int>(position * slices), slices - 1);
    legend.unit = "W/m^2/sr/m";
    legend.caption =
        fmt::format("radiance added a metre in slice {} of {}, from near", slice + 1, slices);
    inspector.params.slice = slice;
    layers.draw(frame);
    inspector.show_values([&] { layers.pass().show_slice(frame); }, Ends::round, legend);
}

void show_density(const Toolbox& tools, Inspector& inspector, const PreparedFrame& frame,
                  const Inspection& wanted, InspectionLegend& legend)
{
    const int axis = wanted.axis;
    const Bounds& media = frame.media;
    const double place = glm::mix(media.min[axis], media.max[axis], wanted.position);
    legend.unit = "1/m";
    legend.caption = fmt::format("extinction at {} = {:.4g} m", "xyz"[axis], place);
    if (legend.high <= 0) {
        // Of all media and not of this plane, or the colours would change as it moves.
        double bound = 0;
        for (const medium::Occupied& one : tools.media.kept_boxes())
            bound += largest_of(one);
        legend.high = scale_end(std::max(bound, kLeastEnd));
    }
    const glm::dvec3 eye = frame.eye.position;
    glm::dvec4 plane(0);
    plane[axis] = 1;
    plane.w = place - eye[axis];
    inspector.params.plane_axis = glm::vec3(plane);
    inspector.params.plane_place = static_cast<float>(plane.w);
    inspector.params.bounds_min = glm::vec3(media.min - eye);
    inspector.params.bounds_max = glm::vec3(media.max - eye);
    inspector.show_values(
        [&] { tools.draw_fullscreen("pass/inspect_density.frag", tools.media.defines()); },
        Ends::round, legend);
    glm::dvec3 low = media.min, high = media.max;
    low[axis] = high[axis] = place;
    // From the eye, as a float holds no world of a million metres.
    inspector.draw_boxes(
        {outline(media.min - eye, media.max - eye), outline(low - eye, high - eye)},
        glm::translate(glm::dmat4(1), eye));
}

void show_bricks(const Toolbox& tools, Inspector& inspector, InspectionLegend& legend)
{
    const std::vector<medium::Occupied> all = tools.media.kept_boxes();
    double bound = 0;
    std::size_t count = 0;
    for (const medium::Occupied& one : all) {
        bound = std::max(bound, largest_of(one));
        count += one.boxes.size();
    }
    legend.unit = "1/m";
    legend.caption =
        fmt::format("largest extinction in {}",
                    count == 1 ? "the one box" : fmt::format("each of {} boxes", count));
    if (legend.high <= 0)
        legend.high = scale_end(std::max(bound, kLeastEnd));
    inspector.set_scale(legend);
    inspector.dim();
    for (const medium::Occupied& one : all) {
        std::vector<BoxInstance> boxes;
        for (const medium::OccupiedBox& box : one.boxes)
            boxes.push_back({glm::vec4(glm::vec3(box.bounds.min), box.most),
                             glm::vec4(glm::vec3(box.bounds.max), 0)});
        inspector.draw_boxes(std::move(boxes), one.world_from_box);
    }
}

InspectionLegend show_probe(const Toolbox& tools, Inspector& inspector, const PreparedFrame& frame,
                            int probe)
{
    InspectionLegend legend{0, 1, "W/m^2/sr", "", false};
    const int count = tools.probes.count();
    if (probe == 0 && count == 0) {
        inspector.dim();
        legend.caption = "probe: the scene has none";
        return legend;
    }
    if (probe < 0 || probe >= count)
        throw Error(fmt::format("there is no probe {}: the scene has {}; probes count from 0",
                                probe, count));
    const LightProbe& place = tools.probes.at(probe);
    legend.caption = fmt::format("probe {} at ({:.3g}, {:.3g}, {:.3g}) m", probe, place.position.x,
                                 place.position.y, place.position.z);
    inspector.params.slice = tools.probes.layer_of(probe);
    if (inspector.params.slice < 0) {
        inspector.dim();
        legend.caption += ", not captured yet";
        return legend;
    }
    tools.probes.bind(frame.eye.position);
    inspector.show("pass/inspect_probe.frag");
    return legend;
}

}  // namespace

InspectionLegend inspect(const Toolbox& tools, Layers& layers, gl::Framebuffer& host,
                         const PreparedFrame& frame, const Inspection& wanted,
                         const std::function<void()>& draw_counts)
{
    check(wanted, frame.settings);
    Inspector inspector(tools, host, frame);
    if (wanted.kind == Kind::scattering || wanted.kind == Kind::transmittance) {
        inspector.show_layer(frame.sees_media ? &layers : nullptr, wanted.kind == Kind::scattering
                                                                       ? Layer::scattering
                                                                       : Layer::transmittance);
        return layer_legend(wanted.kind);
    }
    InspectionLegend legend{.low = 0, .high = wanted.scale, .unit = "", .caption = ""};
    if (wanted.kind == Kind::depth) {
        show_depth(tools, inspector, legend);
        return legend;
    }
    if (wanted.kind == Kind::probe)
        return show_probe(tools, inspector, frame, wanted.probe);
    if (wanted.kind == Kind::layers) {
        legend.caption = "transparent layers, one behind the other";
        inspector.show_values(draw_counts, Ends::round, legend);
        return legend;
    }
    if (!frame.sees_media) {
        inspector.dim();
        legend.high = wanted.scale > 0 ? wanted.scale : 1;
        legend.caption = fmt::format("{}: no media in view", inspection_name(wanted.kind));
        return legend;
    }
    switch (wanted.kind) {
    case Kind::samples:
        show_samples(layers.pass(), inspector, frame, legend);
        break;
    case Kind::froxel_slice:
        show_froxels(layers, inspector, frame, wanted.position, legend);
        break;
    case Kind::density_slice:
        show_density(tools, inspector, frame, wanted, legend);
        break;
    default:
        show_bricks(tools, inspector, legend);
    }
    return legend;
}

}  // namespace fumarole::resolve
