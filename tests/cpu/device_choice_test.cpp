// Which device is taken, as a function of what a machine has: no context is made here.

#include "context/device_choice.h"

namespace fumarole::test {
namespace {

using gl::Backend;
using gl::DeviceDescription;
using testing::HasSubstr;

/// What a machine has, and which of it was looked at: a context costs a tenth of a second.
struct Machine {
    std::vector<DeviceDescription> devices;
    std::vector<std::size_t> looked_at = {};

    gl::DeviceChoice choose(const gl::DeviceRequest& request)
    {
        looked_at.clear();
        std::vector<bool> software;
        for (const DeviceDescription& device : devices)
            software.push_back(device.software);
        return gl::choose_device(request, software, [&](std::size_t i) {
            looked_at.push_back(i);
            return devices[i];
        });
    }
    std::string refusal(const gl::DeviceRequest& request)
    {
        try {
            choose(request);
        } catch (const Error& error) {
            return error.what();
        }
        return "";
    }
};

const DeviceDescription kLlvmpipe{"llvmpipe (LLVM 15.0.6, 256 bits)", "Mesa", "4.5", true, ""};
const DeviceDescription kH200{"NVIDIA H200", "NVIDIA Corporation", "4.5.0 NVIDIA 580", false, ""};
const DeviceDescription kRadeon{"AMD Radeon Pro W7900", "AMD", "4.6 Mesa 24", false, ""};
const DeviceDescription kBroken{"/dev/dri/card0", "", "", false, "EGL can't initialise it"};
constexpr std::optional<std::size_t> kOsMesa;

TEST(DeviceChoice, TakesTheFirstGpuAndLooksAtNoOther)
{
    Machine machine{{kLlvmpipe, kH200, kRadeon}};
    const gl::DeviceChoice choice = machine.choose({});
    EXPECT_EQ(choice.egl_device, 1u);
    EXPECT_THAT(choice.reason, HasSubstr("the first GPU that works of 3"));
    EXPECT_EQ(machine.looked_at, std::vector<std::size_t>{1});
    EXPECT_EQ(machine.choose({Backend::egl}).egl_device, 1u);
    EXPECT_THAT(Machine{{kH200}}.choose({}).reason, HasSubstr("device 0, a GPU"));
}

TEST(DeviceChoice, WithoutAGpuTakesOsMesaAndEglItsRasteriser)
{
    Machine machine{{kLlvmpipe}};
    EXPECT_EQ(machine.choose({}).egl_device, kOsMesa);
    EXPECT_EQ(machine.choose({}).reason, "OSMesa: EGL lists no GPU");
    EXPECT_TRUE(machine.looked_at.empty());
    EXPECT_EQ(machine.choose({Backend::egl}).egl_device, 0u);

    Machine nothing{{}};
    EXPECT_EQ(nothing.choose({}).egl_device, kOsMesa);
    EXPECT_EQ(nothing.choose({}).reason, "OSMesa: EGL lists no device");
    EXPECT_THAT(nothing.refusal({Backend::egl}), HasSubstr("--backend osmesa"));
}

TEST(DeviceChoice, OfARasteriserThatEglDoesNotCallOneTheContextTells)
{
    Machine machine{{kH200}};
    machine.devices[0].name = "llvmpipe";
    const auto look = [&](std::size_t) { return kLlvmpipe; };
    EXPECT_EQ(gl::choose_device({}, {false}, look).egl_device, kOsMesa);
    EXPECT_TRUE(gl::choose_device({}, {false}, look).failures.empty());
}

TEST(DeviceChoice, AGpuThatFailsIsPassedOverAndOnlyForARasteriserTold)
{
    Machine another{{kBroken, kH200}};
    EXPECT_EQ(another.choose({}).egl_device, 1u);
    EXPECT_TRUE(another.choose({}).failures.empty());

    Machine none{{kBroken, kLlvmpipe}};
    const gl::DeviceChoice choice = none.choose({});
    EXPECT_EQ(choice.egl_device, kOsMesa);
    EXPECT_EQ(choice.reason, "OSMesa: no GPU that works");
    ASSERT_EQ(choice.failures.size(), 1u);
    EXPECT_EQ(choice.failures[0],
              "device 0 (/dev/dri/card0) can't be used: EGL can't initialise it");
    EXPECT_EQ(none.choose({Backend::egl}).egl_device, 1u);
    EXPECT_THAT(Machine{{kBroken}}.refusal({Backend::egl}), HasSubstr("can't initialise"));
}

TEST(DeviceChoice, TakesTheDeviceThatIsNamed)
{
    Machine machine{{kLlvmpipe, kH200, kRadeon, kBroken}};
    EXPECT_EQ(machine.choose({Backend::automatic, "2"}).egl_device, 2u);
    EXPECT_EQ(machine.looked_at, std::vector<std::size_t>{2});
    EXPECT_EQ(machine.choose({Backend::automatic, "radeon"}).egl_device, 2u);
    EXPECT_EQ(machine.choose({Backend::egl, "0"}).egl_device, 0u);
    EXPECT_EQ(machine.choose({Backend::automatic, "llvmpipe"}).egl_device, 0u);

    // Of two of one name the first that works.
    machine.devices[1].refusal = "its first dispatch computes wrong numbers";
    machine.devices.push_back(kH200);
    EXPECT_EQ(machine.choose({Backend::automatic, "h200"}).egl_device, 4u);
}

TEST(DeviceChoice, OfADeviceThatIsNotThereSaysWhichAre)
{
    Machine machine{{kLlvmpipe, kH200, kBroken}};
    for (const char* wanted : {"3", "99999999999999999999999", "GeForce", "-1"}) {
        EXPECT_THROW(machine.choose({Backend::automatic, wanted}), gl::NoSuchDevice) << wanted;
        const std::string said = machine.refusal({Backend::automatic, wanted});
        EXPECT_THAT(said, HasSubstr(wanted));
        EXPECT_THAT(said, HasSubstr("1 (NVIDIA H200)"));
    }
    EXPECT_THAT(machine.refusal({Backend::automatic, "2"}), HasSubstr("can't initialise"));
    EXPECT_THAT(Machine{{}}.refusal({Backend::automatic, "0"}), HasSubstr("no device"));
}

}  // namespace
}  // namespace fumarole::test
