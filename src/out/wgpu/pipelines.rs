//! The shader to pipelines: backdrop, surfaces, lattice lines, wireframe, B-rep edges, picking.

use super::formats::{DEPTH_FORMAT, PICK_FORMAT, SAMPLES};
use super::layout::{CellPlace, Record, Vertex};
use ::wgpu::{
    BindGroupLayout, BufferBindingType, ColorTargetState, CompareFunction, ShaderStages, TextureFormat,
    VertexBufferLayout, VertexStepMode,
};

/// The render pipelines. Bind group 0 is the view in all of them; lines read their points from another group.
#[derive(Clone, Debug)]
pub(super) struct Pipelines {
    /// Globals and places.
    pub(super) view: BindGroupLayout,
    /// A page of points.
    pub(super) points: BindGroupLayout,
    /// A page of vertices and one of indices.
    pub(super) triangles: BindGroupLayout,
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
            primitive: ::wgpu::PrimitiveState::default(), // triangle list, counter-clockwise in front, nothing culled
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
    pub(super) fn new(device: &::wgpu::Device, format: TextureFormat) -> Self {
        let shader = device.create_shader_module(::wgpu::ShaderModuleDescriptor {
            label: Some("trimtess"),
            source: ::wgpu::ShaderSource::Wgsl(include_str!("shader.wgsl").into()),
        });
        let read = BufferBindingType::Storage { read_only: true };
        let view = layout(device, &[BufferBindingType::Uniform, read]);
        let points = layout(device, &[read]);
        let triangles = layout(device, &[read, read]);
        let vertex = ::wgpu::vertex_attr_array![0 => Float32x3, 1 => Snorm16x2];
        let vertex = VertexBufferLayout {
            array_stride: size_of::<Vertex>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &vertex,
        };
        let record = ::wgpu::vertex_attr_array![2 => Uint32, 3 => Uint32, 4 => Uint32, 5 => Unorm8x4];
        let record = VertexBufferLayout {
            array_stride: size_of::<Record>() as u64,
            step_mode: VertexStepMode::Instance,
            attributes: &record,
        };
        // Only lines have alpha.
        let lit = ColorTargetState { blend: Some(::wgpu::BlendState::ALPHA_BLENDING), ..format.into() };
        let pipeline = |kind: &PipelineKind<'_>| kind.pipeline(device, &shader);
        let cells = ::wgpu::vertex_attr_array![6 => Float32x2];
        let cells = VertexBufferLayout {
            array_stride: size_of::<CellPlace>() as u64,
            step_mode: VertexStepMode::Vertex,
            attributes: &cells,
        };
        let tiles = [Some(vertex.clone()), Some(record.clone())];
        let surface = PipelineKind {
            vertex: "surface_vertex",
            fragment: "surface_fragment",
            groups: &[Some(&view)],
            buffers: &tiles,
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
                buffers: &[Some(vertex), Some(record.clone()), Some(cells)],
                target: lit.clone(),
                ..line
            }),
            wire: pipeline(&PipelineKind {
                vertex: "wire_vertex",
                groups: &[Some(&view), None, Some(&triangles)],
                buffers: &[Some(record)],
                target: lit.clone(),
                ..line
            }),
            edge: pipeline(&PipelineKind {
                vertex: "edge_vertex",
                groups: &[Some(&view), Some(&points)],
                buffers: &[],
                ..line
            }),
            surface: pipeline(&surface),
            view,
            points,
            triangles,
        }
    }
}

fn layout(device: &::wgpu::Device, types: &[BufferBindingType]) -> BindGroupLayout {
    let entry = |(binding, &ty): (usize, &BufferBindingType)| ::wgpu::BindGroupLayoutEntry {
        binding: binding as u32,
        visibility: ShaderStages::VERTEX
            | if ty == BufferBindingType::Uniform { ShaderStages::FRAGMENT } else { ShaderStages::NONE },
        ty: ::wgpu::BindingType::Buffer { ty, has_dynamic_offset: false, min_binding_size: None },
        count: None,
    };
    let entries: Vec<_> = types.iter().enumerate().map(entry).collect();
    device.create_bind_group_layout(&::wgpu::BindGroupLayoutDescriptor { label: Some("trimtess"), entries: &entries })
}
