//! The shader to pipelines: backdrop, surfaces, lattice lines, wireframe, B-rep edges, picking.

use super::formats::{DEPTH_FORMAT, PICK_FORMAT, SAMPLES};
use super::layout::{CELLS, RECORDS, VERTICES};
use super::surface_input::SurfaceInput;
use ::wgpu::{
    BindGroupLayout, BindingType, BufferBindingType, ColorTargetState, CompareFunction, PrimitiveTopology,
    ShaderStages, TextureFormat, TextureSampleType, TextureViewDimension, VertexBufferLayout,
};

/// The render pipelines. Bind group 0 is the view in all of them.
#[derive(Clone, Debug)]
pub(super) struct Pipelines {
    /// Bind group 0, and what else surfaces need.
    pub(super) input: SurfaceInput,
    /// Points of edges.
    pub(super) points: BindGroupLayout,
    /// A page of vertices and one of indices. Where tiles are not merged.
    pub(super) triangles: Option<BindGroupLayout>,
    pub(super) backdrop: ::wgpu::RenderPipeline,
    pub(super) surface: ::wgpu::RenderPipeline,
    pub(super) lattice: ::wgpu::RenderPipeline,
    pub(super) wire: ::wgpu::RenderPipeline,
    pub(super) edge: ::wgpu::RenderPipeline,
    pub(super) pick: ::wgpu::RenderPipeline,
}

/// The settings in which the pipelines differ.
struct PipelineKind<'a> {
    vertex: &'a str,
    fragment: &'a str,
    groups: &'a [Option<&'a BindGroupLayout>],
    buffers: &'a [Option<VertexBufferLayout<'a>>],
    topology: PrimitiveTopology,
    depth: CompareFunction,
    target: ColorTargetState,
    samples: u32,
}

impl PipelineKind<'_> {
    fn pipeline(&self, device: &::wgpu::Device, shader: &::wgpu::ShaderModule) -> ::wgpu::RenderPipeline {
        let layout = device.create_pipeline_layout(&::wgpu::PipelineLayoutDescriptor {
            label: Some("trimtess"),
            bind_group_layouts: self.groups,
            immediate_size: 0,
        });
        device.create_render_pipeline(&::wgpu::RenderPipelineDescriptor {
            label: Some(self.vertex),
            layout: Some(&layout),
            vertex: ::wgpu::VertexState {
                module: shader,
                entry_point: Some(self.vertex),
                compilation_options: ::wgpu::PipelineCompilationOptions::default(),
                buffers: self.buffers,
            },
            // Counter-clockwise in front, nothing culled.
            primitive: ::wgpu::PrimitiveState { topology: self.topology, ..::wgpu::PrimitiveState::default() },
            depth_stencil: Some(::wgpu::DepthStencilState {
                format: DEPTH_FORMAT,
                depth_write_enabled: Some(self.depth == CompareFunction::Greater),
                depth_compare: Some(self.depth),
                stencil: ::wgpu::StencilState::default(),
                bias: ::wgpu::DepthBiasState::default(),
            }),
            multisample: ::wgpu::MultisampleState { count: self.samples, ..::wgpu::MultisampleState::default() },
            fragment: Some(::wgpu::FragmentState {
                module: shader,
                entry_point: Some(self.fragment),
                compilation_options: ::wgpu::PipelineCompilationOptions::default(),
                targets: &[Some(self.target.clone())],
            }),
            multiview_mask: None,
            cache: None,
        })
    }
}

impl Pipelines {
    /// Those for a device that reads draws from buffers (`indirect`), or for one that merges tiles.
    pub(super) fn new(device: &::wgpu::Device, format: TextureFormat, indirect: bool) -> Self {
        let Layouts { view, points, triangles } = Layouts::new(device, indirect);
        let input = SurfaceInput::new(&view, indirect);
        let lines = if indirect { include_str!("lines_per_tile.wgsl") } else { include_str!("lines_merged.wgsl") };
        let shader = device.create_shader_module(::wgpu::ShaderModuleDescriptor {
            label: Some("trimtess"),
            source: ::wgpu::ShaderSource::Wgsl([input.wgsl, include_str!("shader.wgsl"), lines].concat().into()),
        });
        // Only lines have alpha.
        let lit = ColorTargetState { blend: Some(::wgpu::BlendState::ALPHA_BLENDING), ..format.into() };
        let pipeline = |kind: &PipelineKind<'_>| kind.pipeline(device, &shader);
        let surface = PipelineKind {
            vertex: "surface_vertex",
            fragment: "surface_fragment",
            groups: &[Some(&view)],
            buffers: &input.vertex_buffers,
            topology: PrimitiveTopology::TriangleList,
            depth: CompareFunction::Greater,
            target: lit.clone(),
            samples: SAMPLES,
        };
        let line = PipelineKind {
            fragment: "line_fragment",
            depth: CompareFunction::GreaterEqual,
            target: lit.clone(),
            ..surface
        };
        let wire = if indirect {
            pipeline(&PipelineKind {
                vertex: "wire_vertex",
                groups: &[Some(&view), None, triangles.as_ref()],
                buffers: &[Some(RECORDS)],
                target: lit.clone(),
                ..line
            })
        } else {
            pipeline(&PipelineKind {
                vertex: "wire_vertex",
                buffers: &[Some(VERTICES)],
                topology: PrimitiveTopology::LineList,
                target: lit.clone(),
                ..line
            })
        };
        Self {
            backdrop: pipeline(&PipelineKind {
                vertex: "backdrop_vertex",
                fragment: "backdrop_fragment",
                buffers: &[],
                depth: CompareFunction::Always,
                target: lit.clone(),
                ..surface
            }),
            pick: pipeline(&PipelineKind {
                fragment: "pick_fragment",
                target: PICK_FORMAT.into(),
                samples: 1,
                ..surface
            }),
            lattice: pipeline(&PipelineKind {
                vertex: "lattice_vertex",
                fragment: "lattice_fragment",
                buffers: &[Some(VERTICES), input.vertex_buffers[1].clone(), Some(CELLS)],
                target: lit.clone(),
                ..line
            }),
            wire,
            edge: pipeline(&PipelineKind {
                vertex: "edge_vertex",
                groups: &[Some(&view), Some(&points)],
                buffers: &[],
                ..line
            }),
            surface: pipeline(&surface),
            input,
            points,
            triangles,
        }
    }
}

/// The bindings of the shaders, group by group.
struct Layouts {
    view: BindGroupLayout,
    points: BindGroupLayout,
    triangles: Option<BindGroupLayout>,
}

impl Layouts {
    fn new(device: &::wgpu::Device, indirect: bool) -> Self {
        let array = BindingType::Buffer {
            ty: BufferBindingType::Storage { read_only: true },
            has_dynamic_offset: false,
            min_binding_size: None,
        };
        let texels = |sample_type| BindingType::Texture {
            sample_type,
            view_dimension: TextureViewDimension::D2,
            multisampled: false,
        };
        let rows = texels(TextureSampleType::Float { filterable: false });
        let numbers = texels(TextureSampleType::Uint);
        let uniform =
            BindingType::Buffer { ty: BufferBindingType::Uniform, has_dynamic_offset: false, min_binding_size: None };
        let view = [uniform, uniform, rows, numbers, numbers];
        Self {
            // Records are a vertex buffer where tiles are not merged.
            view: layout(device, if indirect { &view[..4] } else { &view }),
            points: layout(device, &[rows]),
            triangles: indirect.then(|| layout(device, &[array, array])),
        }
    }
}

fn layout(device: &::wgpu::Device, types: &[BindingType]) -> BindGroupLayout {
    let entry = |(binding, &ty): (usize, &BindingType)| {
        let is_storage = matches!(ty, BindingType::Buffer { ty: BufferBindingType::Storage { .. }, .. });
        ::wgpu::BindGroupLayoutEntry {
            binding: binding as u32,
            visibility: if is_storage { ShaderStages::VERTEX } else { ShaderStages::VERTEX_FRAGMENT },
            ty,
            count: None,
        }
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&::wgpu::BindGroupLayoutDescriptor { label: Some("trimtess"), entries: &entries })
}
