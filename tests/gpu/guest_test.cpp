// The renderer is a guest in its host's context: whatever state the host left, the picture is the
// same and the state comes back; nothing of the host's is written but the picture, nothing is left
// behind.

#include <algorithm>
#include <cstring>
#include <fmt/format.h>
#include <map>
#include <regex>

#include "gl/texture.h"
#include "shared/bindings.h"
#include "support/gl_test.h"

namespace fumarole::test {
namespace {

/// The state of a context by name, a piece to a line.
using State = std::map<std::string, std::vector<double>>;

constexpr int kUnits = GRID_UNIT + 2 * MAX_GRIDS;
constexpr int kBlocks = 8;
constexpr int kImages = 8;
constexpr int kDrawBuffers = 8;
constexpr int kViewports = 16;

struct Named {
    const char* name;
    GLenum value;
};
#define FUM_NAMED(name)                                                                            \
    Named                                                                                          \
    {                                                                                              \
#name, name                                                                                \
    }

constexpr std::array kSwitches{FUM_NAMED(GL_DEPTH_TEST),
                               FUM_NAMED(GL_STENCIL_TEST),
                               FUM_NAMED(GL_CULL_FACE),
                               FUM_NAMED(GL_COLOR_LOGIC_OP),
                               FUM_NAMED(GL_RASTERIZER_DISCARD),
                               FUM_NAMED(GL_POLYGON_OFFSET_FILL),
                               FUM_NAMED(GL_POLYGON_OFFSET_LINE),
                               FUM_NAMED(GL_POLYGON_OFFSET_POINT),
                               FUM_NAMED(GL_DEPTH_CLAMP),
                               FUM_NAMED(GL_DITHER),
                               FUM_NAMED(GL_FRAMEBUFFER_SRGB),
                               FUM_NAMED(GL_SAMPLE_MASK),
                               FUM_NAMED(GL_SAMPLE_COVERAGE),
                               FUM_NAMED(GL_SAMPLE_ALPHA_TO_COVERAGE),
                               FUM_NAMED(GL_SAMPLE_ALPHA_TO_ONE),
                               FUM_NAMED(GL_PRIMITIVE_RESTART),
                               FUM_NAMED(GL_PRIMITIVE_RESTART_FIXED_INDEX),
                               FUM_NAMED(GL_CLIP_DISTANCE0),
                               FUM_NAMED(GL_CLIP_DISTANCE5),
                               FUM_NAMED(GL_CLIP_DISTANCE7),
                               FUM_NAMED(GL_POLYGON_SMOOTH),
                               FUM_NAMED(GL_LINE_SMOOTH),
                               FUM_NAMED(GL_PROGRAM_POINT_SIZE),
                               FUM_NAMED(GL_TEXTURE_CUBE_MAP_SEAMLESS),
                               FUM_NAMED(GL_SAMPLE_SHADING)};

constexpr std::array kNumbers{FUM_NAMED(GL_DRAW_FRAMEBUFFER_BINDING),
                              FUM_NAMED(GL_READ_FRAMEBUFFER_BINDING),
                              FUM_NAMED(GL_RENDERBUFFER_BINDING),
                              FUM_NAMED(GL_CURRENT_PROGRAM),
                              FUM_NAMED(GL_PROGRAM_PIPELINE_BINDING),
                              FUM_NAMED(GL_VERTEX_ARRAY_BINDING),
                              FUM_NAMED(GL_ACTIVE_TEXTURE),
                              FUM_NAMED(GL_ARRAY_BUFFER_BINDING),
                              FUM_NAMED(GL_ELEMENT_ARRAY_BUFFER_BINDING),
                              FUM_NAMED(GL_UNIFORM_BUFFER_BINDING),
                              FUM_NAMED(GL_SHADER_STORAGE_BUFFER_BINDING),
                              FUM_NAMED(GL_PIXEL_PACK_BUFFER_BINDING),
                              FUM_NAMED(GL_PIXEL_UNPACK_BUFFER_BINDING),
                              FUM_NAMED(GL_COPY_READ_BUFFER_BINDING),
                              FUM_NAMED(GL_COPY_WRITE_BUFFER_BINDING),
                              FUM_NAMED(GL_DRAW_INDIRECT_BUFFER_BINDING),
                              FUM_NAMED(GL_DISPATCH_INDIRECT_BUFFER_BINDING),
                              FUM_NAMED(GL_CULL_FACE_MODE),
                              FUM_NAMED(GL_FRONT_FACE),
                              FUM_NAMED(GL_POLYGON_MODE),
                              FUM_NAMED(GL_POLYGON_OFFSET_FACTOR),
                              FUM_NAMED(GL_POLYGON_OFFSET_UNITS),
                              FUM_NAMED(GL_DEPTH_FUNC),
                              FUM_NAMED(GL_DEPTH_WRITEMASK),
                              FUM_NAMED(GL_DEPTH_CLEAR_VALUE),
                              FUM_NAMED(GL_COLOR_CLEAR_VALUE),
                              FUM_NAMED(GL_STENCIL_CLEAR_VALUE),
                              FUM_NAMED(GL_CLIP_ORIGIN),
                              FUM_NAMED(GL_CLIP_DEPTH_MODE),
                              FUM_NAMED(GL_BLEND_COLOR),
                              FUM_NAMED(GL_LOGIC_OP_MODE),
                              FUM_NAMED(GL_PRIMITIVE_RESTART_INDEX),
                              FUM_NAMED(GL_LINE_WIDTH),
                              FUM_NAMED(GL_POINT_SIZE),
                              FUM_NAMED(GL_PROVOKING_VERTEX),
                              FUM_NAMED(GL_SAMPLE_COVERAGE_VALUE),
                              FUM_NAMED(GL_SAMPLE_COVERAGE_INVERT),
                              FUM_NAMED(GL_STENCIL_FUNC),
                              FUM_NAMED(GL_STENCIL_REF),
                              FUM_NAMED(GL_STENCIL_VALUE_MASK),
                              FUM_NAMED(GL_STENCIL_FAIL),
                              FUM_NAMED(GL_STENCIL_PASS_DEPTH_FAIL),
                              FUM_NAMED(GL_STENCIL_PASS_DEPTH_PASS),
                              FUM_NAMED(GL_STENCIL_WRITEMASK),
                              FUM_NAMED(GL_STENCIL_BACK_FUNC),
                              FUM_NAMED(GL_STENCIL_BACK_WRITEMASK),
                              FUM_NAMED(GL_PACK_ALIGNMENT),
                              FUM_NAMED(GL_PACK_ROW_LENGTH),
                              FUM_NAMED(GL_PACK_IMAGE_HEIGHT),
                              FUM_NAMED(GL_PACK_SKIP_ROWS),
                              FUM_NAMED(GL_PACK_SKIP_PIXELS),
                              FUM_NAMED(GL_PACK_SKIP_IMAGES),
                              FUM_NAMED(GL_PACK_SWAP_BYTES),
                              FUM_NAMED(GL_UNPACK_ALIGNMENT),
                              FUM_NAMED(GL_UNPACK_ROW_LENGTH),
                              FUM_NAMED(GL_UNPACK_IMAGE_HEIGHT),
                              FUM_NAMED(GL_UNPACK_SKIP_ROWS),
                              FUM_NAMED(GL_UNPACK_SKIP_PIXELS),
                              FUM_NAMED(GL_UNPACK_SKIP_IMAGES),
                              FUM_NAMED(GL_UNPACK_SWAP_BYTES),
                              FUM_NAMED(GL_DRAW_BUFFER0),
                              FUM_NAMED(GL_READ_BUFFER)};

constexpr std::array kBlendOf{FUM_NAMED(GL_BLEND_SRC_RGB),      FUM_NAMED(GL_BLEND_DST_RGB),
                              FUM_NAMED(GL_BLEND_SRC_ALPHA),    FUM_NAMED(GL_BLEND_DST_ALPHA),
                              FUM_NAMED(GL_BLEND_EQUATION_RGB), FUM_NAMED(GL_BLEND_EQUATION_ALPHA)};

constexpr std::array kTextureTargets{FUM_NAMED(GL_TEXTURE_BINDING_1D),
                                     FUM_NAMED(GL_TEXTURE_BINDING_2D),
                                     FUM_NAMED(GL_TEXTURE_BINDING_3D),
                                     FUM_NAMED(GL_TEXTURE_BINDING_1D_ARRAY),
                                     FUM_NAMED(GL_TEXTURE_BINDING_2D_ARRAY),
                                     FUM_NAMED(GL_TEXTURE_BINDING_RECTANGLE),
                                     FUM_NAMED(GL_TEXTURE_BINDING_CUBE_MAP),
                                     FUM_NAMED(GL_TEXTURE_BINDING_CUBE_MAP_ARRAY),
                                     FUM_NAMED(GL_TEXTURE_BINDING_BUFFER),
                                     FUM_NAMED(GL_TEXTURE_BINDING_2D_MULTISAMPLE),
                                     FUM_NAMED(GL_TEXTURE_BINDING_2D_MULTISAMPLE_ARRAY),
                                     FUM_NAMED(GL_SAMPLER_BINDING)};
constexpr std::array kBindTargets{GL_TEXTURE_1D,
                                  GL_TEXTURE_2D,
                                  GL_TEXTURE_3D,
                                  GL_TEXTURE_1D_ARRAY,
                                  GL_TEXTURE_2D_ARRAY,
                                  GL_TEXTURE_RECTANGLE,
                                  GL_TEXTURE_CUBE_MAP,
                                  GL_TEXTURE_CUBE_MAP_ARRAY,
                                  GL_TEXTURE_BUFFER,
                                  GL_TEXTURE_2D_MULTISAMPLE,
                                  GL_TEXTURE_2D_MULTISAMPLE_ARRAY};

State read_state(const gl::Device& gl)
{
    State state;
    for (const Named& s : kSwitches)
        state[s.name] = {double(gl->IsEnabled(s.value))};
    for (const Named& n : kNumbers) {
        std::array<GLdouble, 4> v{};
        gl->GetDoublev(n.value, v.data());
        state[n.name] = {v.begin(), v.end()};
    }
    for (GLuint i = 0; i < kDrawBuffers; ++i) {
        std::vector<double>& v = state[fmt::format("blend and colour mask of buffer {}", i)];
        for (const Named& b : kBlendOf) {
            GLint one = 0;
            gl->GetIntegeri_v(b.value, i, &one);
            v.push_back(one);
        }
        std::array<GLboolean, 4> mask{};
        gl->GetBooleani_v(GL_COLOR_WRITEMASK, i, mask.data());
        v.insert(v.end(), mask.begin(), mask.end());
        v.push_back(gl->IsEnabledi(GL_BLEND, i));
    }
    for (GLuint i = 0; i < kViewports; ++i) {
        std::array<GLfloat, 4> viewport{};
        gl->GetFloati_v(GL_VIEWPORT, i, viewport.data());
        state[fmt::format("viewport {}", i)] = {viewport.begin(), viewport.end()};
        std::array<GLdouble, 2> range{};
        gl->GetDoublei_v(GL_DEPTH_RANGE, i, range.data());
        state[fmt::format("depth range {}", i)] = {range.begin(), range.end()};
        std::array<GLint, 4> box{};
        gl->GetIntegeri_v(GL_SCISSOR_BOX, i, box.data());
        state[fmt::format("scissor box {}", i)] = {box.begin(), box.end()};
        state[fmt::format("scissor test {}", i)] = {double(gl->IsEnabledi(GL_SCISSOR_TEST, i))};
    }
    GLint active = 0;
    gl->GetIntegerv(GL_ACTIVE_TEXTURE, &active);
    for (GLuint unit = 0; unit < kUnits; ++unit) {
        gl->ActiveTexture(GL_TEXTURE0 + unit);
        for (const Named& t : kTextureTargets) {
            GLint bound = 0;
            gl->GetIntegerv(t.value, &bound);
            state[fmt::format("{} of unit {}", t.name, unit)] = {double(bound)};
        }
    }
    gl->ActiveTexture(static_cast<GLenum>(active));
    for (GLuint i = 0; i < kImages; ++i) {
        std::vector<double>& v = state[fmt::format("image unit {}", i)];
        for (const GLenum name :
             {GL_IMAGE_BINDING_NAME, GL_IMAGE_BINDING_LEVEL, GL_IMAGE_BINDING_LAYERED,
              GL_IMAGE_BINDING_LAYER, GL_IMAGE_BINDING_ACCESS, GL_IMAGE_BINDING_FORMAT}) {
            GLint one = 0;
            gl->GetIntegeri_v(name, i, &one);
            v.push_back(one);
        }
    }
    for (const auto& [name, binding, start, size] :
         {std::tuple{"uniform block", GL_UNIFORM_BUFFER_BINDING, GL_UNIFORM_BUFFER_START,
                     GL_UNIFORM_BUFFER_SIZE},
          std::tuple{"storage block", GL_SHADER_STORAGE_BUFFER_BINDING,
                     GL_SHADER_STORAGE_BUFFER_START, GL_SHADER_STORAGE_BUFFER_SIZE}})
        for (GLuint i = 0; i < kBlocks; ++i) {
            GLint buffer = 0;
            GLint64 begin = 0, bytes = 0;
            gl->GetIntegeri_v(binding, i, &buffer);
            gl->GetInteger64i_v(start, i, &begin);
            gl->GetInteger64i_v(size, i, &bytes);
            state[fmt::format("{} {}", name, i)] = {double(buffer), double(begin), double(bytes)};
        }
    return state;
}

void expect_same(const State& before, const State& after, const char* call)
{
    for (const auto& [name, value] : before)
        EXPECT_EQ(value, after.at(name)) << name << " was changed by " << call;
}

/// A host that left everything as no one would expect it.
class OddHost {
public:
    explicit OddHost(const gl::Device& gl) : gl_{gl}
    {
        make_objects();
        set();
    }
    OddHost(const OddHost&) = delete;
    OddHost& operator=(const OddHost&) = delete;
    ~OddHost()
    {
        reset();
        gl_->DeleteTextures(GLsizei(textures_.size()), textures_.data());
        gl_->DeleteBuffers(GLsizei(buffers_.size()), buffers_.data());
        gl_->DeleteSamplers(1, &sampler_);
        gl_->DeleteFramebuffers(2, framebuffers_.data());
        gl_->DeleteVertexArrays(1, &vertex_array_);
        gl_->DeleteProgram(program_);
        gl_->DeleteProgramPipelines(1, &pipeline_);
    }

    /// Back to what a fresh context has.
    void reset() const
    {
        for (const Named& s : kSwitches)
            gl_->Disable(s.value);
        gl_->Enable(GL_DITHER);
        gl_->Disable(GL_BLEND);
        gl_->Disable(GL_SCISSOR_TEST);
        gl_->BlendFunc(GL_ONE, GL_ZERO);
        gl_->BlendEquation(GL_FUNC_ADD);
        gl_->ColorMask(GL_TRUE, GL_TRUE, GL_TRUE, GL_TRUE);
        gl_->BlendColor(0, 0, 0, 0);
        gl_->DepthFunc(GL_LESS);
        gl_->DepthMask(GL_TRUE);
        gl_->DepthRange(0, 1);
        gl_->ClipControl(GL_LOWER_LEFT, GL_NEGATIVE_ONE_TO_ONE);
        gl_->PolygonMode(GL_FRONT_AND_BACK, GL_FILL);
        gl_->LineWidth(1);
        gl_->PolygonOffset(0, 0);
        gl_->CullFace(GL_BACK);
        gl_->FrontFace(GL_CCW);
        gl_->LogicOp(GL_COPY);
        gl_->StencilFunc(GL_ALWAYS, 0, ~0u);
        gl_->StencilOp(GL_KEEP, GL_KEEP, GL_KEEP);
        gl_->StencilMask(~0u);
        gl_->SampleCoverage(1, GL_FALSE);
        gl_->SampleMaski(0, ~0u);
        gl_->MinSampleShading(0);
        gl_->ProvokingVertex(GL_LAST_VERTEX_CONVENTION);
        gl_->PrimitiveRestartIndex(0);
        for (GLenum name : {GL_PACK_ROW_LENGTH, GL_PACK_IMAGE_HEIGHT, GL_PACK_SKIP_ROWS,
                            GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_IMAGES, GL_PACK_SWAP_BYTES,
                            GL_UNPACK_ROW_LENGTH, GL_UNPACK_IMAGE_HEIGHT, GL_UNPACK_SKIP_ROWS,
                            GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES, GL_UNPACK_SWAP_BYTES})
            gl_->PixelStorei(name, 0);
        gl_->PixelStorei(GL_PACK_ALIGNMENT, 4);
        gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 4);
        for (GLuint unit = 0; unit < kUnits; ++unit) {
            gl_->BindTextureUnit(unit, 0);
            gl_->BindSampler(unit, 0);
        }
        gl_->ActiveTexture(GL_TEXTURE0);
        for (GLuint i = 0; i < kImages; ++i)
            gl_->BindImageTexture(i, 0, 0, GL_FALSE, 0, GL_READ_ONLY, GL_R8);
        for (GLuint i = 0; i < kBlocks; ++i) {
            gl_->BindBufferBase(GL_UNIFORM_BUFFER, i, 0);
            gl_->BindBufferBase(GL_SHADER_STORAGE_BUFFER, i, 0);
        }
        for (GLenum target :
             {GL_ARRAY_BUFFER, GL_UNIFORM_BUFFER, GL_SHADER_STORAGE_BUFFER, GL_PIXEL_PACK_BUFFER,
              GL_PIXEL_UNPACK_BUFFER, GL_COPY_READ_BUFFER, GL_COPY_WRITE_BUFFER,
              GL_DRAW_INDIRECT_BUFFER, GL_DISPATCH_INDIRECT_BUFFER})
            gl_->BindBuffer(target, 0);
        gl_->UseProgram(0);
        gl_->BindProgramPipeline(0);
        gl_->BindVertexArray(0);
        gl_->BindFramebuffer(GL_FRAMEBUFFER, 0);
        for (GLuint i = 0; i < kViewports; ++i) {
            gl_->ViewportIndexedf(i, 0, 0, 1, 1);
            gl_->ScissorIndexed(i, 0, 0, 1, 1);
        }
    }

    void set() const
    {
        for (const Named& s : kSwitches)
            gl_->Enable(s.value);
        gl_->Disable(GL_DITHER);
        gl_->DepthFunc(GL_NOTEQUAL);
        gl_->DepthMask(GL_FALSE);
        gl_->ClipControl(GL_UPPER_LEFT, GL_ZERO_TO_ONE);
        gl_->PolygonMode(GL_FRONT_AND_BACK, GL_LINE);
        gl_->PolygonOffset(3, 5);
        gl_->CullFace(GL_FRONT_AND_BACK);
        gl_->FrontFace(GL_CW);
        gl_->LogicOp(GL_XOR);
        gl_->StencilFunc(GL_NEVER, 3, 0x5a);
        gl_->StencilOp(GL_INCR, GL_DECR, GL_INVERT);
        gl_->StencilMask(0x3c);
        gl_->SampleCoverage(0.25f, GL_TRUE);
        gl_->SampleMaski(0, 0);
        gl_->MinSampleShading(0.5f);
        gl_->ProvokingVertex(GL_FIRST_VERTEX_CONVENTION);
        gl_->PrimitiveRestartIndex(2);
        gl_->ClearColor(0.1f, 0.2f, 0.3f, 0.4f);
        gl_->ClearDepth(0.3);
        gl_->ClearStencil(7);
        gl_->BlendColor(0.4f, 0.3f, 0.2f, 0.1f);
        gl_->PointSize(3);
        gl_->LineWidth(2);
        for (GLuint i = 0; i < kDrawBuffers; ++i) {
            if (i % 3 != 1)
                gl_->Enablei(GL_BLEND, i);
            else
                gl_->Disablei(GL_BLEND, i);
            gl_->BlendFuncSeparatei(i, GL_DST_COLOR, GL_CONSTANT_ALPHA, GL_SRC_ALPHA,
                                    i % 2 == 0 ? GL_ZERO : GL_ONE_MINUS_SRC_ALPHA);
            gl_->BlendEquationSeparatei(i, GL_FUNC_REVERSE_SUBTRACT, i % 2 == 0 ? GL_MIN : GL_MAX);
            gl_->ColorMaski(i, i % 2 == 0, GL_FALSE, GL_TRUE, i % 3 == 0);
        }
        for (GLuint i = 0; i < kViewports; ++i) {
            const auto f = static_cast<GLfloat>(i);
            gl_->ViewportIndexedf(i, 1 + f, 2.5f, 3 + f, 5);
            gl_->DepthRangeIndexed(i, 0.9, 0.1 + 0.01 * i);
            gl_->ScissorIndexed(i, GLint(i), 1, 2, 3);
            if (i % 2 == 0)
                gl_->Enablei(GL_SCISSOR_TEST, i);
            else
                gl_->Disablei(GL_SCISSOR_TEST, i);
        }
        gl_->PixelStorei(GL_PACK_ALIGNMENT, 8);
        gl_->PixelStorei(GL_UNPACK_ALIGNMENT, 8);
        for (GLenum name : {GL_PACK_ROW_LENGTH, GL_UNPACK_ROW_LENGTH, GL_PACK_IMAGE_HEIGHT,
                            GL_UNPACK_IMAGE_HEIGHT})
            gl_->PixelStorei(name, 129);
        for (GLenum name : {GL_PACK_SKIP_ROWS, GL_PACK_SKIP_PIXELS, GL_PACK_SKIP_IMAGES,
                            GL_UNPACK_SKIP_ROWS, GL_UNPACK_SKIP_PIXELS, GL_UNPACK_SKIP_IMAGES})
            gl_->PixelStorei(name, 1);
        gl_->PixelStorei(GL_PACK_SWAP_BYTES, GL_TRUE);
        gl_->PixelStorei(GL_UNPACK_SWAP_BYTES, GL_TRUE);
        for (GLuint unit = 0; unit < kUnits; ++unit) {
            gl_->ActiveTexture(GL_TEXTURE0 + unit);
            for (std::size_t t = 0; t < kBindTargets.size(); ++t)
                gl_->BindTexture(kBindTargets.at(t), textures_.at(t));
            gl_->BindSampler(unit, sampler_);
        }
        gl_->ActiveTexture(GL_TEXTURE0 + 13);
        for (GLuint i = 0; i < kImages; ++i)
            gl_->BindImageTexture(i, textures_[4], 0, i % 2 == 0, 1, GL_READ_WRITE, GL_R32UI);
        for (GLuint i = 0; i < kBlocks; ++i) {
            gl_->BindBufferRange(GL_UNIFORM_BUFFER, i, buffers_[0], 256, 512);
            gl_->BindBufferRange(GL_SHADER_STORAGE_BUFFER, i, buffers_[0], 256, 512);
        }
        gl_->BindBufferBase(GL_UNIFORM_BUFFER, MEDIA_BLOCK, buffers_[1]);
        gl_->BindVertexArray(vertex_array_);
        gl_->BindBuffer(GL_ARRAY_BUFFER, buffers_[1]);
        gl_->BindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers_[2]);
        gl_->BindBuffer(GL_UNIFORM_BUFFER, buffers_[3]);
        gl_->BindBuffer(GL_SHADER_STORAGE_BUFFER, buffers_[4]);
        gl_->BindBuffer(GL_PIXEL_PACK_BUFFER, buffers_[5]);
        gl_->BindBuffer(GL_PIXEL_UNPACK_BUFFER, buffers_[6]);
        gl_->BindBuffer(GL_COPY_READ_BUFFER, buffers_[1]);
        gl_->BindBuffer(GL_COPY_WRITE_BUFFER, buffers_[2]);
        gl_->BindBuffer(GL_DRAW_INDIRECT_BUFFER, buffers_[3]);
        gl_->BindBuffer(GL_DISPATCH_INDIRECT_BUFFER, buffers_[4]);
        gl_->UseProgram(program_);
        gl_->BindProgramPipeline(pipeline_);
        gl_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, framebuffers_[0]);
        gl_->BindFramebuffer(GL_READ_FRAMEBUFFER, framebuffers_[1]);
    }

    /// What is in the host's buffers and in the textures that it bound.
    [[nodiscard]] std::vector<unsigned char> contents() const
    {
        std::vector<unsigned char> all;
        for (const GLuint buffer : buffers_) {
            std::vector<unsigned char> bytes(kBytes);
            gl_->GetNamedBufferSubData(buffer, 0, kBytes, bytes.data());
            all.insert(all.end(), bytes.begin(), bytes.end());
        }
        std::vector<unsigned char> texels(kTexels * kTexels * 4);
        gl_->GetTextureImage(textures_[1], 0, GL_RGBA, GL_UNSIGNED_BYTE, GLsizei(texels.size()),
                             texels.data());
        all.insert(all.end(), texels.begin(), texels.end());
        return all;
    }

private:
    static constexpr GLsizei kBytes = 65536;
    static constexpr GLsizei kTexels = 16;

    void make_objects()
    {
        for (std::size_t t = 0; t < kBindTargets.size(); ++t)
            gl_->CreateTextures(kBindTargets.at(t), 1, &textures_.at(t));
        gl_->TextureStorage1D(textures_[0], 1, GL_RGBA8, kTexels);
        gl_->TextureStorage2D(textures_[1], 1, GL_RGBA8, kTexels, kTexels);
        gl_->TextureStorage3D(textures_[2], 1, GL_RGBA8, kTexels, kTexels, 2);
        gl_->TextureStorage2D(textures_[3], 1, GL_RGBA8, kTexels, 2);
        gl_->TextureStorage3D(textures_[4], 1, GL_RGBA8, kTexels, kTexels, 2);
        gl_->TextureStorage2D(textures_[5], 1, GL_RGBA8, kTexels, kTexels);
        gl_->TextureStorage2D(textures_[6], 1, GL_RGBA8, kTexels, kTexels);
        gl_->TextureStorage3D(textures_[7], 1, GL_RGBA8, kTexels, kTexels, 6);
        gl_->TextureStorage2DMultisample(textures_[9], 4, GL_RGBA8, kTexels, kTexels, GL_TRUE);
        gl_->TextureStorage3DMultisample(textures_[10], 4, GL_RGBA8, kTexels, kTexels, 2, GL_TRUE);
        const std::vector<unsigned char> junk(kBytes, 0xa5);
        gl_->CreateBuffers(GLsizei(buffers_.size()), buffers_.data());
        for (const GLuint buffer : buffers_)
            gl_->NamedBufferStorage(buffer, kBytes, junk.data(), GL_DYNAMIC_STORAGE_BIT);
        gl_->TextureBuffer(textures_[8], GL_RGBA8, buffers_[4]);
        gl_->TextureSubImage2D(textures_[1], 0, 0, 0, kTexels, kTexels, GL_RGBA, GL_UNSIGNED_BYTE,
                               junk.data());
        gl_->CreateSamplers(1, &sampler_);
        gl_->SamplerParameteri(sampler_, GL_TEXTURE_MIN_FILTER, GL_NEAREST_MIPMAP_NEAREST);
        gl_->SamplerParameteri(sampler_, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_BORDER);
        gl_->SamplerParameterf(sampler_, GL_TEXTURE_LOD_BIAS, 3);
        gl_->CreateFramebuffers(2, framebuffers_.data());
        for (const GLuint framebuffer : framebuffers_)
            gl_->NamedFramebufferTexture(framebuffer, GL_COLOR_ATTACHMENT0, textures_[1], 0);
        gl_->CreateVertexArrays(1, &vertex_array_);
        // A separable program has to declare what it writes of gl_PerVertex, or it does not link.
        const char* source = "#version 450 core\n"
                             "out gl_PerVertex { vec4 gl_Position; };\n"
                             "void main() { gl_Position = vec4(0.0); }\n";
        program_ = gl_->CreateShaderProgramv(GL_VERTEX_SHADER, 1, &source);
        GLint linked = GL_FALSE;
        gl_->GetProgramiv(program_, GL_LINK_STATUS, &linked);
        EXPECT_EQ(linked, GL_TRUE) << "the host's own program";
        gl_->CreateProgramPipelines(1, &pipeline_);
    }

    const gl::Device& gl_;
    std::array<GLuint, kBindTargets.size()> textures_{};
    std::array<GLuint, 7> buffers_{};
    std::array<GLuint, 2> framebuffers_{};
    GLuint sampler_ = 0, vertex_array_ = 0, program_ = 0, pipeline_ = 0;
};

/// Bricked smoke, coloured glow, two lights and a floor: every pass runs and every block is bound.
Scene busy_scene()
{
    auto grid = std::make_shared<VoxelGrid>();
    grid->name = "smoke";
    grid->bricks = {{0, 0, 0}, {1, 0, 0}, {40, 0, 0}};
    for (int i = 0; i < 3 * 512; ++i)
        grid->values.push_back(0.2f + static_cast<float>(i * 37 % 101) / 101);
    grid->index_min = {0, 0, 0};
    grid->index_max = {327, 7, 7};
    grid->active_voxels = 3 * 512;
    grid->max_value = 1.2f;
    grid->world_from_index = glm::dmat4(0.1);
    grid->world_from_index[3] = {-0.8, -6, -0.4, 1};
    GridMedium smoke;
    smoke.density = grid;
    smoke.sigma_s_per_density = {1, 2, 3};
    smoke.g = 0.3f;
    BoxMedium fog;
    fog.min = {-3, -9, -1};
    fog.max = {3, -2, 1};
    fog.sigma_s = glm::vec3(0.05f);
    fog.emission = {0.02f, 0.01f, 0};

    Scene scene = empty_scene(32);
    scene.resolution = {37, 26};
    scene.camera.vfov_deg = 30;
    scene.world.radiance = {0.1f, 0.2f, 0.3f};
    scene.lights = {SunLight{{0.3, 0.2, 1}, {3, 3, 3}}, PointLight{{1, -5, 0.5}, {2, 3, 4}}};
    scene.media = {smoke, fog};
    scene.surfaces = {BoxSurface{{-9, -20, -1.2}, {9, 0, -1}, {0.5f, 0.4f, 0.3f}},
                      SphereSurface{{0.3, -7, 0}, 0.4, {0.6f, 0.6f, 0.6f}}};
    return scene;
}

/// The host of docs/library.md: a sun and one grid, no world, no surfaces. Most that the passes
/// might bind is not there.
Scene sparse_scene()
{
    Scene scene = busy_scene();
    scene.media.pop_back();
    std::get<GridMedium>(scene.media.front()).sigma_s_per_density = glm::vec3(2);
    scene.lights.pop_back();
    scene.world = {};
    scene.surfaces.clear();
    return scene;
}

/// Sparser: fog that is grey, under a sky.
Scene grey_fog()
{
    Scene scene = busy_scene();
    scene.media.erase(scene.media.begin());
    std::get<BoxMedium>(scene.media.front()).emission = glm::vec3(0);
    scene.lights.clear();
    scene.surfaces.clear();
    return scene;
}

/// All that is busy, seen through panes: a filter, a picture, and one that asks for what is behind.
Scene glassy_scene()
{
    Scene scene = busy_scene();
    QuadTransparent filter;
    filter.corner = {-1, -5, -1};
    filter.edges = {glm::dvec3(2, -1, 0), glm::dvec3(0, 0, 2)};
    filter.look.blend.kind = Blend::Kind::multiply;
    filter.look.filter = {0.5f, 0.9f, 0.7f};
    filter.look.casts = true;
    QuadTransparent asks = filter;
    asks.edges[0] = {2, 1, 0};
    asks.look.casts = false;
    asks.look.blend = {Blend::Kind::factors, BlendFactor::one_minus_dst_color,
                       BlendFactor::dst_color};
    asks.look.radiance = {0.1f, 0.2f, 0.3f};
    BillboardTransparent board;
    board.center = {0, -6, 0};
    auto image = std::make_shared<TransparentImage>();
    image->width = image->height = 2;
    image->texels = {{1, 0, 0, 1}, {0, 0.5f, 0, 0.5f}, {0, 0, 0, 0}, {0.2f, 0.2f, 0.2f, 0.2f}};
    board.look.image = image;
    board.look.depth_fade = 0.5f;
    scene.transparents = {filter, asks, board};
    return scene;
}

Settings small_settings(Settings::Mode mode = Settings::Mode::raymarch)
{
    Settings settings;
    settings.mode = mode;
    settings.slices = 16;
    settings.tile = 4;
    settings.shadow_map = 64;
    settings.steps = 16;
    settings.shadow_steps = 4;
    settings.bounces = 0;
    return settings;
}

/// A host's picture with an alpha and a stencil of its own.
struct Picture {
    explicit Picture(const gl::Device& gl, const Scene& scene)
        : color{gl::Texture::make_2d(gl, "picture", glm::ivec2(scene.resolution), GL_RGBA32F,
                                     gl::Filter::nearest)},
          depth{gl::Texture::make_2d(gl, "depth", glm::ivec2(scene.resolution),
                                     GL_DEPTH_COMPONENT32F, gl::Filter::nearest)}
    {
        frame.color = color.view();
        frame.depth = depth.view();
        frame.depth_convention = {.zero_to_one = true, .reversed = true};
        frame.view_from_world = view_from_world(scene.camera);
        frame.clip_from_view = clip_from_view(scene.camera, scene.resolution, {0, 0});
    }
    gl::Texture color, depth;
    Frame frame;
};

constexpr TransparentBindings kHostsLists{5, 6, 3, 2};
const char* const kBegin = "begin_transparents";

/// What begin_transparents() binds for a host, and nothing else.
State without_lists(State state)
{
    for (const char* name :
         {"GL_DRAW_FRAMEBUFFER_BINDING", "GL_DRAW_BUFFER0", "viewport 0",
          "GL_UNIFORM_BUFFER_BINDING", "GL_SHADER_STORAGE_BUFFER_BINDING", "uniform block 5",
          "storage block 2", "storage block 3", "image unit 3", "GL_TEXTURE_BINDING_2D of unit 6",
          "GL_SAMPLER_BINDING of unit 6"})
        EXPECT_EQ(state.erase(name), 1u) << name;
    return state;
}

struct Results {
    std::vector<float> surfaces, composite, depth;
    LayerImages layers;
    TransparentImages transparents;
    double samples = 0;
    std::vector<std::vector<float>> insides;  ///< RGBA of each inspection
    std::vector<std::string> explained;
};

/// The kinds that a mode has.
std::vector<Inspection> inspections(const Settings& settings)
{
    std::vector<Inspection> all;
    for (const InspectionInfo& info : inspection_table())
        if (info.kind != Inspection::Kind::froxel_slice || settings.mode == Settings::Mode::froxel)
            all.push_back({.kind = info.kind, .axis = 1});
    return all;
}

/// What a volume took to fill is another time each time.
std::vector<std::string> without_times(std::vector<std::string> lines)
{
    static const std::regex time(" in [0-9.]+ ms");
    for (std::string& line : lines)
        line = std::regex_replace(line, time, "");
    return lines;
}

/// Bit for bit, or how many numbers differ and by how much.
void expect_bits(const std::vector<float>& a, const std::vector<float>& b, const char* what)
{
    ASSERT_EQ(a.size(), b.size()) << what;
    std::size_t differ = 0;
    float most = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        differ += a[i] == b[i] ? 0 : 1;
        most = std::max(most, std::abs(a[i] - b[i]));
    }
    EXPECT_EQ(differ, 0u) << what << ": of " << a.size() << " numbers, by " << most << " at most";
}

/// A march that keeps its layer from frame to frame.
Settings temporal_settings()
{
    Settings settings = small_settings();
    settings.temporal = true;
    return settings;
}

class Guest : public GlTest, public testing::WithParamInterface<Settings> {};

INSTANTIATE_TEST_SUITE_P(Modes, Guest,
                         testing::Values(small_settings(), temporal_settings(),
                                         small_settings(Settings::Mode::froxel)),
                         [](const auto& settings) {
                             return settings.param.temporal
                                        ? std::string("temporal")
                                        : std::string(mode_name(settings.param.mode));
                         });

/// Draws a scene in every way that there is, in a fresh context and for an OddHost, and expects the
/// same bits, and the host's state back after each call.
/// @param has_own the host has transparents of its own
void expect_good_manners(const gl::Device& gl, gl::GetProc get_proc, const Scene& scene,
                         const Settings& settings, bool has_own = true)
{
    const std::vector<Inspection> kinds = inspections(settings);
    const auto draw = [&](Renderer& renderer, Picture& picture, std::vector<Picture>& insides,
                          const auto& after) {
        Results results;
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        after("set_scene");
        if (has_own)
            picture.frame.transparents = {TransparentExtent{}};
        renderer.prepare(picture.frame, settings);
        after("prepare");
        renderer.wait_until_ready();
        after("wait_until_ready");
        renderer.draw_surfaces(picture.frame, settings, false);
        after("draw_surfaces");
        renderer.draw_surfaces(picture.frame, settings, true);
        after("draw_surfaces through media");
        results.samples = renderer.count_samples(view, picture.frame, settings);
        after("count_samples");
        if (has_own) {
            renderer.begin_transparents(view, picture.frame, settings, kHostsLists);
            after(kBegin);
            renderer.end_transparents(view);
            after("end_transparents");
        }
        renderer.composite(view, picture.frame, settings);
        after("composite");
        if (has_own) {
            EXPECT_NE(view.volume_at().block, 0u);
            after("volume_at");
        }
        results.layers = renderer.read_layers(view, picture.frame, settings);
        after("read_layers");
        results.transparents = renderer.read_transparents(view, picture.frame, settings);
        after("read_transparents");
        Settings mono = settings;
        mono.targets = Settings::Targets::mono;
        mono.resolution = 1;
        renderer.composite(view, picture.frame, mono);
        after("composite in one target");
        for (std::size_t i = 0; i < kinds.size(); ++i) {
            renderer.draw_surfaces(insides[i].frame, settings, false);
            renderer.inspect(view, insides[i].frame, settings, kinds[i]);
            after(fmt::format("inspect {}", inspection_name(kinds[i].kind)).c_str());
        }
        results.explained = renderer.explain(settings);
        after("explain");
        renderer.set_timing(Timing::queries);
        renderer.composite(view, picture.frame, settings);
        after("composite, timed");
        renderer.set_timing(Timing::finish);
        renderer.composite(view, picture.frame, settings);
        after("composite, measured");
        renderer.take_report();
        after("take_report");
        renderer.set_scene(empty_scene(), settings);
        after("set_scene to nothing");
        return results;
    };
    const auto make_insides = [&] {
        std::vector<Picture> insides;
        for (std::size_t i = 0; i < kinds.size(); ++i)
            insides.emplace_back(gl, scene);
        return insides;
    };
    const auto read = [&](Results& results, const Picture& picture,
                          const std::vector<Picture>& insides) {
        for (const Picture& inside : insides)
            results.insides.push_back(inside.color.read(4));
        results.composite = picture.color.read(4);
        results.depth = gl::read_texture(gl, picture.depth.view(), 1, true);
    };

    Results clean;
    {
        Renderer renderer(get_proc);
        View view = renderer.make_view();
        Picture picture(gl, scene);
        std::vector<Picture> insides = make_insides();
        clean = draw(renderer, picture, insides, [](const char*) {});
        read(clean, picture, insides);
    }

    Picture picture(gl, scene);
    std::vector<Picture> insides = make_insides();
    std::unique_ptr<Renderer> renderer;
    Results odd;
    {
        const OddHost host(gl);
        const State before = read_state(gl);
        const auto after = [&](const char* call) {
            if (call == kBegin) {
                expect_same(without_lists(before), read_state(gl), call);
                return;
            }
            expect_same(before, read_state(gl), call);
            host.set();  // so that one fault is not told twice
        };
        renderer = std::make_unique<Renderer>(get_proc);
        after("Renderer's constructor");
        odd = draw(*renderer, picture, insides, after);
        renderer.reset();
        after("Renderer's destructor");
        host.reset();
        read(odd, picture, insides);
        const std::vector<unsigned char> contents = host.contents();
        EXPECT_TRUE(std::all_of(contents.begin(), contents.end(), [](unsigned char c) {
            return c == 0xa5;
        })) << "something of the host's was written";
    }

    expect_bits(clean.composite, odd.composite, "composite");
    expect_bits(clean.depth, odd.depth, "depth");
    expect_bits(clean.layers.scattering, odd.layers.scattering, "scattering");
    expect_bits(clean.layers.transmittance, odd.layers.transmittance, "transmittance");
    expect_bits(clean.transparents.added, odd.transparents.added, "added");
    expect_bits(clean.transparents.kept, odd.transparents.kept, "kept");
    for (std::size_t i = 0; i < kinds.size(); ++i)
        expect_bits(clean.insides[i], odd.insides[i], inspection_name(kinds[i].kind).data());
    EXPECT_EQ(clean.samples, odd.samples);
    EXPECT_EQ(without_times(clean.explained), without_times(odd.explained));
    // That the scene is worth comparing.
    EXPECT_GT(clean.samples, 100);
    EXPECT_EQ(*std::min_element(clean.depth.begin(), clean.depth.end()) ==
                  *std::max_element(clean.depth.begin(), clean.depth.end()),
              scene.surfaces.empty());
    EXPECT_LT(
        *std::min_element(clean.layers.transmittance.begin(), clean.layers.transmittance.end()),
        0.9f);
}

TEST_P(Guest, LeavesTheStateAndDrawsTheSamePictureWhateverItIs)
{
    expect_good_manners(gl(), get_proc(), busy_scene(), GetParam());
}

TEST_P(Guest, LeavesTheStateOfUnitsThatASparseSceneHasNothingFor)
{
    expect_good_manners(gl(), get_proc(), sparse_scene(), GetParam());
}

TEST_P(Guest, LeavesTheStateOfUnitsThatGreyFogHasNothingFor)
{
    expect_good_manners(gl(), get_proc(), grey_fog(), GetParam());
}

TEST_P(Guest, LeavesTheStateOfTheListsOfTransparents)
{
    expect_good_manners(gl(), get_proc(), glassy_scene(), GetParam());
}

TEST_P(Guest, LeavesTheStateOfTransparentsInOrder)
{
    Scene scene = glassy_scene();
    scene.transparents.erase(scene.transparents.begin() + 1);  // the one that asks
    auto mesh = std::make_shared<Mesh>();
    mesh->positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    mesh->normals.assign(4, glm::vec3(0, 0, 1));
    mesh->triangles = {0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3};
    MeshTransparent glass;
    glass.mesh = mesh;
    glass.translate = {-0.5, -8, -0.5};
    glass.look.alpha = 0.5f;
    scene.transparents.emplace_back(glass);
    expect_good_manners(gl(), get_proc(), scene, GetParam(), false);
    Picture picture(gl(), scene);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, GetParam());
    renderer.composite(view, picture.frame, GetParam());
    renderer.wait_until_ready();
    EXPECT_EQ(renderer.fragment_count(), FragmentCount{}) << "those in order are in no list";
}

TEST_P(Guest, LeavesTheStateOfTransparentsInPieces)
{
    Scene scene = glassy_scene();
    scene.transparents.erase(scene.transparents.begin() + 1);
    std::get<BillboardTransparent>(scene.transparents.back()).center = {0.1, -5.4, 0.2};
    expect_good_manners(gl(), get_proc(), scene, GetParam(), false);
    Picture picture(gl(), scene);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, GetParam());
    renderer.composite(view, picture.frame, GetParam());
    renderer.wait_until_ready();
    EXPECT_EQ(renderer.fragment_count(), FragmentCount{}) << "pieces are in no list";
}

class GuestByCompute : public GlTest {};

TEST_F(GuestByCompute, LeavesTheStateAndDrawsTheSamePictureWhateverItIs)
{
    // The march with all that it can have, and of froxels the resolve, which is what they differ
    // by.
    Settings march = temporal_settings(), froxel = small_settings(Settings::Mode::froxel);
    march.passes = froxel.passes = Settings::Passes::compute;
    expect_good_manners(gl(), get_proc(), glassy_scene(), march);
    expect_good_manners(gl(), get_proc(), sparse_scene(), froxel);
}

TEST_P(Guest, CompositeWritesColourAloneAndKeepsItsAlpha)
{
    const Scene scene = glassy_scene();
    const Settings settings = GetParam();
    Picture picture(gl(), scene);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    renderer.draw_surfaces(picture.frame, settings, true);
    std::vector<float> before = picture.color.read(4);
    for (std::size_t i = 0; i < before.size(); i += 4)
        before[i + 3] = static_cast<float>(i % 97) / 97.0f;
    picture.color.upload(GL_RGBA, GL_FLOAT, before.data());
    const std::vector<float> depth = gl::read_texture(gl(), picture.depth.view(), 1, true);
    for (const auto targets : {Settings::Targets::two, Settings::Targets::mono}) {
        Settings s = settings;
        s.targets = targets;
        renderer.composite(view, picture.frame, s);
        const std::vector<float> after = picture.color.read(4);
        bool changed = false;
        for (std::size_t i = 0; i < after.size(); i += 4) {
            ASSERT_EQ(after[i + 3], before[i + 3]) << "alpha of texel " << i / 4;
            changed |= after[i] != before[i];
        }
        EXPECT_TRUE(changed);
    }
    EXPECT_EQ(depth, gl::read_texture(gl(), picture.depth.view(), 1, true));
}

TEST_P(Guest, CompositeIsColourTimesTransmittancePlusScattering)
{
    const Scene scene = busy_scene();
    const Settings settings = GetParam();
    Picture picture(gl(), scene);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    renderer.draw_surfaces(picture.frame, settings, true);
    const std::vector<float> before = picture.color.read(4);
    renderer.composite(view, picture.frame, settings);
    const std::vector<float> after = picture.color.read(4);
    const LayerImages layers = renderer.read_layers(view, picture.frame, settings);
    for (std::size_t i = 0; i < before.size() / 4; ++i)
        for (std::size_t c = 0; c < 3; ++c)
            ASSERT_NEAR(after[i * 4 + c],
                        before[i * 4 + c] * layers.transmittance[i * 3 + c] +
                            layers.scattering[i * 3 + c],
                        1e-5 * (1 + after[i * 4 + c]))
                << "texel " << i;
}

TEST_P(Guest, WithoutMediaThePictureKeepsItsBits)
{
    Scene scene = busy_scene();
    scene.media.clear();
    const Settings settings = GetParam();
    Picture picture(gl(), scene);
    Renderer renderer(get_proc());
    View view = renderer.make_view();
    renderer.set_scene(scene, settings);
    renderer.wait_until_ready();
    std::vector<float> bits(picture.color.read(4).size());
    for (std::size_t i = 0; i < bits.size(); ++i)
        bits[i] = -0.1f * static_cast<float>(i);
    picture.color.upload(GL_RGBA, GL_FLOAT, bits.data());
    renderer.composite(view, picture.frame, settings);
    EXPECT_EQ(picture.color.read(4), bits);
    EXPECT_EQ(renderer.count_samples(view, picture.frame, settings), 0);
    for (const float t : renderer.read_layers(view, picture.frame, settings).transmittance)
        ASSERT_EQ(t, 1);
}

/// How many of the first names of each kind are objects.
std::map<std::string, int> count_objects(const gl::Device& gl)
{
    constexpr GLuint kNames = 3000;
    std::map<std::string, int> count;
    for (GLuint id = 1; id < kNames; ++id) {
        count["textures"] += gl->IsTexture(id);
        count["buffers"] += gl->IsBuffer(id);
        count["framebuffers"] += gl->IsFramebuffer(id);
        count["vertex arrays"] += gl->IsVertexArray(id);
        count["programs"] += gl->IsProgram(id);
        count["shaders"] += gl->IsShader(id);
        count["queries"] += gl->IsQuery(id);
        count["samplers"] += gl->IsSampler(id);
    }
    return count;
}

TEST_P(Guest, LeavesNothingBehind)
{
    const Scene scene = busy_scene();
    const Settings settings = GetParam();
    Picture picture(gl(), scene);
    {
        // Mesa keeps the program that was used last until another is: one from before we count.
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        renderer.set_scene(scene, settings);
        renderer.wait_until_ready();
        renderer.composite(view, picture.frame, settings);
    }
    const std::map<std::string, int> objects = count_objects(gl());
    {
        Renderer renderer(get_proc());
        View view = renderer.make_view();
        const std::uint64_t bare = renderer.device().bytes();
        const auto frame = [&] {
            renderer.set_scene(scene, settings);
            renderer.wait_until_ready();
            renderer.draw_surfaces(picture.frame, settings, true);
            renderer.composite(view, picture.frame, settings);
            renderer.read_layers(view, picture.frame, settings);
            renderer.count_samples(view, picture.frame, settings);
            for (const Inspection& inspection : inspections(settings))
                renderer.inspect(view, picture.frame, settings, inspection);
        };
        frame();
        const std::uint64_t full = renderer.device().bytes();
        const std::map<std::string, int> held = count_objects(gl());
        EXPECT_GT(full, bare);
        const std::uint64_t made = renderer.take_report().allocations;
        for (int i = 0; i < 3; ++i) {
            renderer.draw_surfaces(picture.frame, settings, true);
            renderer.composite(view, picture.frame, settings);
        }
        EXPECT_EQ(renderer.take_report().allocations, made) << "a frame allocates";
        // Into a texture of its own, and of froxels by a V-buffer of its own: what is integrated
        // lies where theirs was.
        renderer.count_samples(view, picture.frame, settings);
        EXPECT_LE(renderer.take_report().allocations,
                  made + (settings.mode == Settings::Mode::froxel ? 3 : 1));
        for (int i = 0; i < 3; ++i)
            frame();
        EXPECT_EQ(renderer.device().bytes(), full) << "the same frames again";
        EXPECT_EQ(count_objects(gl()), held) << "the same frames again";

        renderer.set_scene(empty_scene(), settings);
        const std::uint64_t layer = renderer.device().bytes();
        frame();
        EXPECT_EQ(renderer.device().bytes(), full) << "the scene, after none";
        renderer.set_scene(empty_scene(), settings);
        EXPECT_EQ(renderer.device().bytes(), layer) << "none, again";
        // What stays is not the scene's: the layers of a frame of this size, as they are and at
        // full size, twice more where they are kept, or its froxels (of coloured extinction and a
        // history), and small blocks.
        const std::uint64_t texels = 19 * 13, froxels = 12 * 9 * 17;
        const std::uint64_t of_pass = settings.mode == Settings::Mode::froxel
                                          ? froxels * 24
                                          : texels * (8 + 8 + 4 + (settings.temporal ? 64 : 0));
        EXPECT_LE(layer, bare + of_pass + 3 * 16384);
        EXPECT_EQ(renderer.take_report().gpu_bytes, layer);
        {
            const View gone = std::move(view);
        }
        EXPECT_LT(renderer.device().bytes() + of_pass / 2, layer) << "a view that is gone";
    }
    // Fewer is no fault: Mesa frees an object of an earlier test when its last use is replaced.
    for (const auto& [kind, count] : count_objects(gl()))
        EXPECT_LE(count, objects.at(kind)) << kind << " outlive the Renderer";
}

TEST_P(Guest, TwoRenderersInOneContextAndMovesDontMixUp)
{
    const Settings settings = GetParam();
    const Scene busy = busy_scene();
    Scene other = busy;
    other.media.erase(other.media.begin());
    other.lights.pop_back();
    other.surfaces.pop_back();
    const auto draw = [&](Renderer& renderer, const Scene& scene) {
        Picture picture(gl(), scene);
        View view = renderer.make_view();
        renderer.draw_surfaces(picture.frame, settings, true);
        renderer.composite(view, picture.frame, settings);
        return picture.color.read(4);
    };
    std::vector<float> alone_busy, alone_other;
    {
        Renderer renderer(get_proc());
        renderer.set_scene(busy, settings);
        renderer.wait_until_ready();
        alone_busy = draw(renderer, busy);
        renderer.set_scene(other, settings);
        renderer.wait_until_ready();
        alone_other = draw(renderer, other);
    }
    EXPECT_NE(alone_busy, alone_other);
    auto a = std::make_unique<Renderer>(get_proc());
    Renderer b(get_proc());
    a->set_scene(busy, settings);
    a->wait_until_ready();
    b.set_scene(other, settings);
    b.wait_until_ready();
    EXPECT_EQ(draw(*a, busy), alone_busy);
    EXPECT_EQ(draw(b, other), alone_other);
    Renderer moved = std::move(*a);
    a.reset();
    EXPECT_EQ(draw(moved, busy), alone_busy);
    moved = std::move(b);
    EXPECT_EQ(draw(moved, other), alone_other);
}

}  // namespace
}  // namespace fumarole::test
