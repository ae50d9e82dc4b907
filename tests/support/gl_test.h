#pragma once

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "context/headless_context.h"
#include "gl/device.h"
#include <fumarole/scene_renderer.h>

namespace fumarole::test {

/// A test with an OpenGL context, one for the whole binary (OSMesa; EGL with FUM_TEST_BACKEND=egl),
/// with the debug callback on: any GL error or undefined behaviour that the driver reports fails,
/// and so does a program that needs more than OpenGL 4.5 promises.
class GlTest : public testing::Test {
protected:
    GlTest();
    ~GlTest() override;

    static gl::GetProc get_proc();
    static const gl::Device& gl();

    /// Renders with a SceneRenderer that the binary keeps, so programs compile once.
    static Still render(const Scene& scene, const Settings& settings, int aa = 1,
                        StillReport* report = nullptr);
    static SceneRenderer& scene_renderer();

    /// A rasteriser on the processor, whose arithmetic is IEEE's and whose filters work in floats.
    /// OpenGL promises neither, and GPUs have neither.
    static bool is_software() { return gl().capabilities().software; }
    /// By how much of a texel a filtered lookup's place may be off, along each axis: GPUs round it
    /// to 8 bits of fraction (Vulkan's subTexelPrecisionBits of NVIDIA, AMD and Intel).
    static double filter_rounding() { return is_software() ? 0 : 0x1p-9; }
};

/// Has glslangValidator check all shaders in a folder. @returns what it says and its exit code; a
/// machine without it says nothing.
std::pair<std::string, int> validate_shaders(const std::filesystem::path& folder);

/// RGB of one pixel, rows from the top.
glm::vec3 pixel(const std::vector<float>& rgb, int width, int x, int y);

/// A camera at the origin that looks along -y, 20 degrees high, z up; picture of size x size.
Scene empty_scene(int size = 32);

}  // namespace fumarole::test
