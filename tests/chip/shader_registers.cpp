// What a compiler for a chip that is not here makes of compute shaders: registers, waves that fit
// beside each other, and whether any number has to be kept in memory.
//   shader_registers FILE.spv...     tests/chip/run makes the files
// Mesa's RADV compiles for the AMD chip that RADV_FORCE_FAMILY names, on any machine. Exit code 1
// if a shader spills.
#include <array>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string>
#include <vector>
#include <vulkan/vulkan.h>

namespace {

// Numbers of bindings that each kind of resource has, from BINDINGS times its place on: by options
// of glslangValidator in tests/chip/run. There are more than any shader has.
constexpr std::uint32_t kBindings = 100;
constexpr std::array kKinds{VK_DESCRIPTOR_TYPE_COMBINED_IMAGE_SAMPLER,
                            VK_DESCRIPTOR_TYPE_STORAGE_IMAGE, VK_DESCRIPTOR_TYPE_UNIFORM_BUFFER,
                            VK_DESCRIPTOR_TYPE_STORAGE_BUFFER};

void check(VkResult result, const char* what)
{
    if (result != VK_SUCCESS)
        throw std::runtime_error(std::string(what) + ": VkResult " + std::to_string(result));
}

VkDevice make_device()
{
    VkApplicationInfo application{VK_STRUCTURE_TYPE_APPLICATION_INFO};
    application.apiVersion = VK_API_VERSION_1_1;
    VkInstanceCreateInfo instance_info{VK_STRUCTURE_TYPE_INSTANCE_CREATE_INFO};
    instance_info.pApplicationInfo = &application;
    VkInstance instance = VK_NULL_HANDLE;
    check(vkCreateInstance(&instance_info, nullptr, &instance), "no Vulkan");
    std::uint32_t count = 1;
    VkPhysicalDevice chip = VK_NULL_HANDLE;
    vkEnumeratePhysicalDevices(instance, &count, &chip);
    if (count == 0)
        throw std::runtime_error("no chip to compile for");
    VkPhysicalDeviceProperties properties;
    vkGetPhysicalDeviceProperties(chip, &properties);
    std::printf("%s\n", properties.deviceName);

    const float priority = 1;
    VkDeviceQueueCreateInfo queue{VK_STRUCTURE_TYPE_DEVICE_QUEUE_CREATE_INFO};
    queue.queueCount = 1;
    queue.pQueuePriorities = &priority;
    VkPhysicalDevicePipelineExecutablePropertiesFeaturesKHR told{
        VK_STRUCTURE_TYPE_PHYSICAL_DEVICE_PIPELINE_EXECUTABLE_PROPERTIES_FEATURES_KHR};
    told.pipelineExecutableInfo = VK_TRUE;
    const char* const extension = VK_KHR_PIPELINE_EXECUTABLE_PROPERTIES_EXTENSION_NAME;
    VkDeviceCreateInfo info{VK_STRUCTURE_TYPE_DEVICE_CREATE_INFO};
    info.pNext = &told;
    info.queueCreateInfoCount = 1;
    info.pQueueCreateInfos = &queue;
    info.enabledExtensionCount = 1;
    info.ppEnabledExtensionNames = &extension;
    VkDevice device = VK_NULL_HANDLE;
    check(vkCreateDevice(chip, &info, nullptr, &device), "no device");
    return device;
}

VkPipelineLayout make_layout(VkDevice device)
{
    std::vector<VkDescriptorSetLayoutBinding> bindings;
    for (std::uint32_t kind = 0; kind < kKinds.size(); ++kind)
        for (std::uint32_t i = 0; i < kBindings; ++i)
            bindings.push_back(
                {kind * kBindings + i, kKinds[kind], 1, VK_SHADER_STAGE_COMPUTE_BIT, nullptr});
    VkDescriptorSetLayoutCreateInfo set_info{VK_STRUCTURE_TYPE_DESCRIPTOR_SET_LAYOUT_CREATE_INFO};
    set_info.bindingCount = static_cast<std::uint32_t>(bindings.size());
    set_info.pBindings = bindings.data();
    VkDescriptorSetLayout set = VK_NULL_HANDLE;
    check(vkCreateDescriptorSetLayout(device, &set_info, nullptr, &set), "bindings");
    VkPipelineLayoutCreateInfo info{VK_STRUCTURE_TYPE_PIPELINE_LAYOUT_CREATE_INFO};
    info.setLayoutCount = 1;
    info.pSetLayouts = &set;
    VkPipelineLayout layout = VK_NULL_HANDLE;
    check(vkCreatePipelineLayout(device, &info, nullptr, &layout), "layout");
    return layout;
}

std::vector<std::uint32_t> read_words(const std::string& path)
{
    std::ifstream file(path, std::ios::binary);
    const std::string bytes((std::istreambuf_iterator<char>(file)), {});
    if (!file || bytes.size() < 20)
        throw std::runtime_error(path + ": can't be read");
    std::vector<std::uint32_t> words(bytes.size() / 4);
    std::memcpy(words.data(), bytes.data(), words.size() * 4);
    return words;
}

/// Instructions that look up a texture, in a module's text: those of a loop count once.
int lookups(const std::vector<std::uint32_t>& words)
{
    constexpr std::uint32_t kSample = 87, kSampleLod = 88, kFetch = 95, kGather = 96;
    int count = 0;
    for (std::size_t i = 5; i < words.size() && (words[i] >> 16) > 0; i += words[i] >> 16) {
        const std::uint32_t op = words[i] & 0xffff;
        count += op == kSample || op == kSampleLod || op == kFetch || op == kGather ? 1 : 0;
    }
    return count;
}

VkPipeline compile(VkDevice device, VkPipelineLayout layout,
                   const std::vector<std::uint32_t>& words)
{
    VkShaderModuleCreateInfo module_info{VK_STRUCTURE_TYPE_SHADER_MODULE_CREATE_INFO};
    module_info.codeSize = words.size() * 4;
    module_info.pCode = words.data();
    VkShaderModule module = VK_NULL_HANDLE;
    check(vkCreateShaderModule(device, &module_info, nullptr, &module), "shader");
    VkComputePipelineCreateInfo info{VK_STRUCTURE_TYPE_COMPUTE_PIPELINE_CREATE_INFO};
    info.flags = VK_PIPELINE_CREATE_CAPTURE_STATISTICS_BIT_KHR;
    info.stage.sType = VK_STRUCTURE_TYPE_PIPELINE_SHADER_STAGE_CREATE_INFO;
    info.stage.stage = VK_SHADER_STAGE_COMPUTE_BIT;
    info.stage.module = module;
    info.stage.pName = "main";
    info.layout = layout;
    VkPipeline pipeline = VK_NULL_HANDLE;
    check(vkCreateComputePipelines(device, VK_NULL_HANDLE, 1, &info, nullptr, &pipeline),
          "pipeline");
    return pipeline;
}

/// The figures of a pipeline that are called so, as RADV has them; 0 of one that it has not.
template <std::size_t N>
std::array<std::uint64_t, N> figures(VkDevice device, VkPipeline pipeline,
                                     const std::array<const char*, N>& names)
{
    const auto get = reinterpret_cast<PFN_vkGetPipelineExecutableStatisticsKHR>(
        vkGetDeviceProcAddr(device, "vkGetPipelineExecutableStatisticsKHR"));
    VkPipelineExecutableInfoKHR which{VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_INFO_KHR};
    which.pipeline = pipeline;
    std::uint32_t count = 0;
    check(get(device, &which, &count, nullptr), "figures");
    std::vector<VkPipelineExecutableStatisticKHR> all(
        count, {VK_STRUCTURE_TYPE_PIPELINE_EXECUTABLE_STATISTIC_KHR});
    check(get(device, &which, &count, all.data()), "figures");
    std::array<std::uint64_t, N> out{};
    for (std::size_t i = 0; i < N; ++i)
        for (const VkPipelineExecutableStatisticKHR& one : all)
            if (std::strcmp(one.name, names[i]) == 0)
                out[i] = one.value.u64;
    return out;
}

}  // namespace

int main(int argc, char** argv)
try {
    const VkDevice device = make_device();
    const VkPipelineLayout layout = make_layout(device);
    constexpr std::array kNames{"VGPRs",   "Subgroups per SIMD", "Instructions",
                                "Latency", "Spilled VGPRs",      "Spilled SGPRs"};
    std::printf("%-32s %9s %6s %13s %8s %8s %7s\n", "shader", "registers", "waves", "instructions",
                "latency", "lookups", "spilled");
    for (int i = 1; i < argc; ++i) {
        const std::vector<std::uint32_t> words = read_words(argv[i]);
        const auto [registers, waves, instructions, latency, vector, scalar] =
            figures(device, compile(device, layout, words), kNames);
        const std::string path = argv[i];
        const std::string name = path.substr(path.find_last_of('/') + 1);
        std::printf("%-32s %9d %6d %13d %8d %8d %7d\n", name.substr(0, name.find(".spv")).c_str(),
                    int(registers), int(waves), int(instructions), int(latency), lookups(words),
                    int(vector + scalar));
    }
    return 0;
} catch (const std::exception& error) {
    std::fprintf(stderr, "shader_registers: %s\n", error.what());
    return 1;
}
