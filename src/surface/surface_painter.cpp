#include "surface/surface_painter.h"

#include <algorithm>
#include <functional>
#include <glm/gtc/matrix_transform.hpp>

#include "shared/bindings.h"

namespace fumarole::surface {

namespace {

/// A surface pixel shows one shadow ray where a ray's samples average many: it gets this many times
/// the steps. (Bands of 16 steps show in a smoke's shadow on the ground, bands of 64 do not.)
constexpr int kShadowFactor = 4;

/// A mesh of more vertices than this is drawn once, and not once for each band of a picture.
constexpr int kFewVertices = 512;

/// Directions to the lights, if they are suns alone; else none.
std::optional<std::vector<glm::dvec3>> suns_of(const Toolbox& tools)
{
    std::vector<glm::dvec3> to_suns;
    for (const LightPosition& light : tools.lights.points()) {
        if (!light.far)
            return {};
        to_suns.push_back(light.at);
    }
    return to_suns;
}

gl::Defines lit_by(const Toolbox& tools)
{
    gl::Defines defines = tools.lights.defines();
    if (tools.lights.has_environment())
        defines.emplace_back("kEnvironment", "");
    return defines;
}

const gl::Program& program_of(const Toolbox& tools, const SurfaceSet::Instance& instance,
                              gl::Defines variant)
{
    if (!instance.closed)
        variant.emplace_back("kTwoSided", "");
    if (instance.gloss)
        variant.emplace_back("GLOSSY", "");
    return tools.programs.get({"pass/surface.vert", "pass/surface.frag"}, variant);
}

}  // namespace

FrameSettings surface_settings(const FrameSettings& settings)
{
    FrameSettings s = settings;
    s.shadow_steps *= kShadowFactor;
    s.resolution = 1;  // no layer is theirs
    return s;
}

void SurfacePainter::draw(const Toolbox& tools, const SurfaceSet& surfaces,
                          const PreparedFrame& frame, bool dimmed, const std::vector<bool>& unseen)
{
    const gl::Device& gl = tools.device;
    const Frame& host = frame.host;
    const bool reversed = host.depth_convention.reversed;
    gl->BindBufferBase(GL_UNIFORM_BUFFER, DRAW_BLOCK, block_.id());
    framebuffer_.attach_color({host.color});
    framebuffer_.attach_depth(host.depth);
    framebuffer_.bind(frame.picture_size);
    gl->ClipControl(GL_LOWER_LEFT,
                    host.depth_convention.zero_to_one ? GL_ZERO_TO_ONE : GL_NEGATIVE_ONE_TO_ONE);
    gl->DepthMask(GL_TRUE);
    const GLfloat sky = reversed ? 0.0f : 1.0f;
    gl->ClearNamedFramebufferfv(framebuffer_.id(), GL_DEPTH, 0, &sky);

    const gl::Defines lights = lit_by(tools);
    if (tools.lights.has_environment())
        tools.lights.bind_environment();
    tools.draw_fullscreen("pass/sky.frag", lights);

    if (tools.lights.has_environment())
        tools.lights.bind_irradiance();
    gl->Enable(GL_DEPTH_TEST);
    gl->DepthFunc(reversed ? GL_GREATER : GL_LESS);
    gl::Defines plain = lights;
    plain += tools.probes.defines();
    for (const Share& share : shares_of(tools, surfaces, frame, plain, dimmed))
        draw_share(tools, surfaces, frame, share, unseen);
    gl->NamedFramebufferTexture(framebuffer_.id(), GL_COLOR_ATTACHMENT0, 0, 0);
    gl->NamedFramebufferTexture(framebuffer_.id(), GL_DEPTH_ATTACHMENT, 0, 0);
}

void SurfacePainter::prepare(const Toolbox& tools, const SurfaceSet& surfaces)
{
    if (!tools.device.capabilities().software || !tools.volumes.lit_on_surfaces())
        return;
    gl::Defines plain = lit_by(tools);
    plain += tools.probes.defines();
    plain += tools.volumes.beyond_defines();
    for (const auto& instance : surfaces.instances())
        program_of(tools, instance, plain);
}

std::vector<SurfacePainter::Share> SurfacePainter::shares_of(const Toolbox& tools,
                                                             const SurfaceSet& surfaces,
                                                             const PreparedFrame& frame,
                                                             const gl::Defines& plain, bool dimmed)
{
    const light::LightVolumes& volumes = tools.volumes;
    gl::Defines near = plain;
    near += volumes.surface_defines();
    gl::Defines through = near;
    through += tools.media.defines();
    through += volumes.defines();
    through.emplace_back("THROUGH_MEDIA", "");
    if (tools.scene_settings.shadow_range == SceneSettings::ShadowRange::light)
        through.emplace_back("kShadowToLight", "");
    if (!tools.device.capabilities().software)
        return {{dimmed ? through : near, {}}};

    std::vector<Share> shares;
    const auto instances = surfaces.instances();
    std::vector<bool> is_left(instances.size(), true);
    const auto add = [&](const gl::Defines& variant, const auto& part_of) {
        Share share{variant, {}};
        for (std::size_t i = 0; i < instances.size(); ++i) {
            if (!is_left[i]) {
                share.bands.emplace_back(std::in_place);
                continue;
            }
            const bool few = surfaces.vertices_drawn(instances[i]) <= kFewVertices;
            share.bands.push_back(few ? part_of(instances[i].bounds) : std::nullopt);
            is_left[i] = share.bands.back().has_value();
        }
        shares.push_back(std::move(share));
    };
    if (dimmed) {
        const auto to_suns = suns_of(tools);
        Bounds media = frame.media;
        const glm::dvec3 blur = volumes.depths().blur();
        media.min -= blur;
        media.max += blur;
        add(through, [&](const Bounds& surface) {
            return to_suns ? dimmed_part(frame, media, surface, *to_suns) : std::nullopt;
        });
    }
    if (const auto box = volumes.lit_on_surfaces())
        add(near, [&](const Bounds& surface) {
            return box->contains(surface) ? std::nullopt : part_within(frame, *box, surface);
        });
    if (std::none_of(is_left.begin(), is_left.end(), std::identity{}))
        return shares;
    gl::Defines beyond = plain;
    beyond += volumes.beyond_defines();
    add(volumes.lit_on_surfaces() ? beyond : near, [](const Bounds&) { return Bands(); });
    return shares;
}

void SurfacePainter::draw_share(const Toolbox& tools, const SurfaceSet& surfaces,
                                const PreparedFrame& frame, const Share& share,
                                const std::vector<bool>& unseen)
{
    const gl::Device& gl = tools.device;
    const Eye& eye = frame.eye;
    const glm::dmat4 view_from_eye(glm::transpose(eye.world_from_view));
    for (const auto& instance : surfaces.instances()) {
        const auto number = static_cast<std::size_t>(&instance - surfaces.instances().data());
        if (number < unseen.size() && unseen[number])
            continue;
        const Bands own_bands = share.bands.empty() ? std::nullopt : share.bands[number];
        if (own_bands && own_bands->empty())
            continue;
        if (instance.gloss)
            ltc_.bind(LTC_UNIT);
        gl->UseProgram(program_of(tools, instance, share.variant).id());
        shared::DrawParams params{};
        const glm::dmat4 eye_from_object =
            glm::translate(glm::dmat4(1.0), -eye.position) * instance.world_from_object;
        params.clip_from_object =
            glm::mat4(frame.host.clip_from_view * view_from_eye * eye_from_object);
        params.world_from_object = glm::mat4(eye_from_object);
        params.albedo = instance.albedo;
        params.emission = instance.emission;
        if (instance.gloss) {
            params.roughness = instance.gloss->roughness;
            params.metallic = instance.gloss->metallic;
        }
        block_.write(params);
        if (!own_bands) {
            surfaces.draw(instance);
            continue;
        }
        gl->Enablei(GL_SCISSOR_TEST, 0);
        for (const PictureBand& band : *own_bands) {
            gl->ScissorIndexed(0, band.low.x, band.low.y, band.size.x, band.size.y);
            surfaces.draw(instance);
        }
        gl->Disablei(GL_SCISSOR_TEST, 0);
    }
}

}  // namespace fumarole::surface
