// A host that draws transparents of its own through the media, by both ways of docs/library.md, and
// holds them against the closed form of a pane in a fog that glows.
#include <glad/gl.h>

#include <cmath>
#include <cstdio>
#include <string>

#include "osmesa_context.h"
#include "picture.h"

namespace {

constexpr double kDepth = 5, kNear = 4, kFar = 6;  // of the pane and of the fog's faces [m]
const glm::dvec3 kSigma(0.3, 0.8, 1.5);            // [1/m]
const glm::dvec3 kGlow(0.5, 1.0, 0.25);            // [W/m^2/sr per metre]
const glm::dvec3 kSky(0.75, 0.25, 0.5);            // [W/m^2/sr]
const glm::vec4 kColor(0.25f, 0.5f, 1.0f, 0.25f);  // the pane's

// A triangle that covers the picture, as deep as a pane would be.
const std::string vertex = R"(#version 450 core
uniform mat4 clip_from_view;
out float view_z;
void main()
{
    view_z = 5.0;
    vec2 corner = vec2(gl_VertexID == 1 ? 60.0 : -20.0, gl_VertexID == 2 ? 60.0 : -20.0);
    gl_Position = clip_from_view * vec4(corner, -view_z, 1.0);
}
)";

// [lists] binding points that nothing of the host's has meanwhile
const fumarole::TransparentBindings lists{
    .block = 1, .depth_unit = 3, .lists_image = 2, .first_buffer = 4};
const std::string into_lists = "#version 450 core\n" + fumarole::transparent_glsl(lists) + R"(
uniform vec4 color;  // radiance and alpha; of FUMAROLE_BLEND_MULTIPLY, what is let through
uniform uint kind, draw;
void main()
{
    const uint blends[3] = uint[](FUMAROLE_BLEND_ALPHA, FUMAROLE_BLEND_ADD, FUMAROLE_BLEND_MULTIPLY);
    fumarole_transparent(color, blends[kind], draw);
}
)";

// [shaded]
const fumarole::VolumeAtBindings media_points{.block = 2, .first_unit = 5};
const std::string look_up = "#version 450 core\n" + fumarole::volume_at_glsl(media_points) + R"(
uniform vec4 color;
in float view_z;
)";
const std::string alpha = look_up + R"(
out vec4 pixel;
void main()
{
    fumarole_VolumeAt media = fumarole_volume_at(gl_FragCoord.xy, view_z);
    pixel = vec4(color.a * (media.transmittance * color.rgb + media.scattering), color.a);
}
)";

const std::string add = look_up + R"(
out vec4 pixel;
void main()
{
    pixel = vec4(fumarole_volume_at(gl_FragCoord.xy, view_z).transmittance * color.rgb, 0.0);
}
)";

const std::string multiply = look_up + R"(
layout(location = 0, index = 0) out vec4 pixel;
layout(location = 0, index = 1) out vec4 kept;
void main()
{
    pixel = vec4(fumarole_volume_at(gl_FragCoord.xy, view_z).scattering * (1.0 - color.rgb), 0.0);
    kept = vec4(color.rgb, 1.0);
}
)";

GLuint make_program(const std::string& fragment)
{
    const GLuint program = glCreateProgram();
    for (const auto& [stage, text] :
         {std::pair{GL_VERTEX_SHADER, &vertex}, std::pair{GL_FRAGMENT_SHADER, &fragment}}) {
        const GLuint shader = glCreateShader(static_cast<GLenum>(stage));
        const char* source = text->c_str();
        glShaderSource(shader, 1, &source, nullptr);
        glCompileShader(shader);
        char log[2000] = "";
        glGetShaderInfoLog(shader, sizeof log, nullptr, log);
        std::fputs(log, stderr);
        glAttachShader(program, shader);
        glDeleteShader(shader);
    }
    glLinkProgram(program);
    return program;
}

fumarole::Scene fog_scene()
{
    fumarole::BoxMedium fog;
    fog.min = {-90, -90, -kFar};
    fog.max = {90, 90, -kNear};
    fog.sigma_a = kSigma;
    fog.emission = kGlow;
    fumarole::Scene scene;
    scene.media = {fog};
    return scene;
}

/// What is seen at a pixel from the lower left. @param kind 0: alpha, 1: add, 2: multiply
glm::dvec3 closed_form(const fumarole::Frame& frame, glm::ivec2 pixel, unsigned kind)
{
    const glm::dvec2 ndc = (glm::dvec2(pixel) + 0.5) / glm::dvec2(frame.color.size) * 2.0 - 1.0;
    const glm::dmat4& clip = frame.clip_from_view;
    const double slant = glm::length(glm::dvec3(ndc.x / clip[0][0], ndc.y / clip[1][1], 1));
    const auto passed = [&](double depth) { return glm::exp(-kSigma * (depth - kNear) * slant); };
    const auto glowed = [&](double depth) { return kGlow / kSigma * (1.0 - passed(depth)); };
    const glm::dvec3 behind =
        (kSky * passed(kFar) + glowed(kFar) - glowed(kDepth)) / passed(kDepth);
    const glm::dvec3 own(kColor);
    const double cover = static_cast<double>(kColor.a);
    const glm::dvec3 in_front = kind == 0   ? own * cover + behind * (1 - cover)
                                : kind == 1 ? own + behind
                                            : own * behind;
    return in_front * passed(kDepth) + glowed(kDepth);
}

}  // namespace

int main()
{
    if (!make_osmesa_context() || gladLoadGL(OSMesaGetProcAddress) == 0)
        return 1;
    const Picture picture;
    GLuint framebuffer = 0, vertices = 0;
    glCreateFramebuffers(1, &framebuffer);
    glNamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, picture.color, 0);
    glCreateVertexArrays(1, &vertices);
    glBindVertexArray(vertices);

    fumarole::Frame frame;
    frame.color = {picture.color, {picture.size, 1}};
    frame.depth = {picture.depth, {picture.size, 1}};
    frame.clip_from_view = glm::perspective(glm::radians(35.0), 16.0 / 9.0, 0.1, 100.0);

    fumarole::Renderer renderer(OSMesaGetProcAddress);
    renderer.set_scene(fog_scene(), fumarole::SceneSettings{});
    const auto draw = [&](GLuint program, unsigned kind) {
        glUseProgram(program);
        const glm::mat4 clip(frame.clip_from_view);
        glUniformMatrix4fv(glGetUniformLocation(program, "clip_from_view"), 1, GL_FALSE,
                           &clip[0][0]);
        glUniform4fv(glGetUniformLocation(program, "color"), 1, &kColor[0]);
        glUniform1ui(glGetUniformLocation(program, "kind"), kind);
        glDrawArrays(GL_TRIANGLES, 0, 3);
    };
    const GLuint lists_program = make_program(into_lists);
    const GLuint shading_programs[3] = {make_program(alpha), make_program(add),
                                        make_program(multiply)};

    double worst = 0;
    for (const auto mode :
         {fumarole::FrameSettings::Mode::raymarch, fumarole::FrameSettings::Mode::froxel}) {
        fumarole::FrameSettings settings;
        settings.mode = mode;
        fumarole::View view = renderer.make_view();
        for (const bool listed : {true, false})
            for (unsigned kind = 0; kind < 3; ++kind) {
                const float sky[4] = {float(kSky.r), float(kSky.g), float(kSky.b), 1};
                glClearTexImage(picture.color, 0, GL_RGBA, GL_FLOAT, sky);
                if (listed) {
                    // [lists]
                    frame.transparents = {{.view_z = {5, 5}}};  // metres; where, for a march
                    renderer.begin_transparents(view, frame, settings, lists);
                    draw(lists_program, kind);  // as many as there are, in any order
                    renderer.end_transparents(view);
                    renderer.composite(view, frame, settings);
                } else {
                    // [shaded]
                    frame.transparents = {{.view_z = {5, 5}}};
                    renderer.composite(view, frame, settings);
                    const fumarole::VolumeAtNames media = view.volume_at();
                    glBindBufferBase(GL_UNIFORM_BUFFER, media_points.block, media.block);
                    glBindTextures(media_points.first_unit, fumarole::kVolumeAtUnits,
                                   media.textures.data());
                    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffer);
                    glViewport(0, 0, picture.size.x, picture.size.y);
                    glEnable(GL_BLEND);
                    if (kind == 0)
                        glBlendFunc(GL_ONE, GL_ONE_MINUS_SRC_ALPHA);
                    else if (kind == 1)
                        glBlendFunc(GL_ONE, GL_ONE);
                    else
                        glBlendFunc(GL_ONE, GL_SRC1_COLOR);
                    draw(shading_programs[kind], kind);
                    glDisable(GL_BLEND);
                    glBindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
                }
                std::vector<glm::vec3> pixels(
                    static_cast<std::size_t>(picture.size.x * picture.size.y));
                glGetTextureImage(picture.color, 0, GL_RGB, GL_FLOAT,
                                  static_cast<GLsizei>(pixels.size() * sizeof(glm::vec3)),
                                  pixels.data());
                for (const glm::ivec2 at : {picture.size / 2, glm::ivec2(0), picture.size - 1}) {
                    const glm::dvec3 seen(
                        pixels[static_cast<std::size_t>(at.y * picture.size.x + at.x)]);
                    const glm::dvec3 error = glm::abs(seen - closed_form(frame, at, kind));
                    worst = std::max({worst, error.r, error.g, error.b});
                }
            }
    }
    const GLenum error = glGetError();
    std::printf("own panes in fog, listed and shaded: off the closed form by %g, GL error %#x\n",
                worst, error);
    // A picture of 16 bits, of values up to 2, and layers of less than its size.
    return worst < 3e-3 && error == GL_NO_ERROR ? 0 : 1;
}
